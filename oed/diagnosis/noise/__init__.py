"""What no model of the motion explains: its size and colour, and where the sign of friction turns."""
