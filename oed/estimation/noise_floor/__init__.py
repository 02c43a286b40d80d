"""What no model of the motion explains: its size and colour, where friction turns its sign, and how certain each row is."""
