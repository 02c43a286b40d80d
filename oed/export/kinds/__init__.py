"""What a model becomes: one file a form, each with a function `write`."""
