"""Recordings: what was measured, read and written, and the signals made of it."""
