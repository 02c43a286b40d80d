"""What is said of a model that was found: names, sizes, intervals, torque budget, errors."""
