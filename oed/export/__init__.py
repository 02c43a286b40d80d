"""Identified robots for others: URDF, SDF, MJCF, a Drake plant, and parameters in YAML."""
