"""The search: candidates are screened, added while they predict, and judged by the whole model."""
