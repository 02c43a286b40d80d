"""White rows and linear fits to them."""
