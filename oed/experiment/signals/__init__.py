"""Signal processing, one operation a function; nothing here knows of robots."""
