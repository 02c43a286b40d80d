"""Files to hand on: provenance, tables, figures, pages. It draws what it is given, never computes."""
