"""What the JSON files of the commands say, as types: their JSON Schemas are made from these."""
