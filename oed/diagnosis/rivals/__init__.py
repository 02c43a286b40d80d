"""Effects that the data cannot tell apart, and the motion that will."""
