"""What a user runs: one thin file a command, made from frozen configurations."""
