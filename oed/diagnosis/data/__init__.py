"""Recordings in the analysis band, and where they cannot be trusted."""
