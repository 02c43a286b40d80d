"""What rows tell of a model and of each of its terms: fit, log score, worth."""
