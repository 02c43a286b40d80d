"""The rows that all is judged on: one band, whitened, weighted by how certain their direction is."""
