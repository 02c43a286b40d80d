"""What may be added: effects of the catalogue over their shapes, and free-form terms."""
