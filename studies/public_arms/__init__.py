"""Public recordings of measured arms: ours beside the models that were published with them."""
