"""The model before any addition, and the noise that it leaves."""
