"""A room of the diagnosis by evidence: see METHOD.md."""
