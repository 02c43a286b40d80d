"""The motion that tells alternatives apart."""
