"""The catalogue's entries, grouped by what they describe."""
