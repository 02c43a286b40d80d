"""The recordings laid out as white rows, and fits to them with any additions."""
