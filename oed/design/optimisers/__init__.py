"""Optimisers of one problem object; each a function of the same shape."""
