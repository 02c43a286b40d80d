"""What a search may add: effects of the catalogue at their places, and smooth terms."""
