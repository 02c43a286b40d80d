"""Which additions the data demand."""
