"""What may be said of them: uncertainty, verdict, proof."""
