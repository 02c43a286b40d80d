"""Which motion to ask for: trajectory classes, criteria, exact limits and optimisers."""
