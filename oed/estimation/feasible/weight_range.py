"""Weights of the pull to a prior that a solution can have: apart from what loads a solver.

The misfit is of size one where the pull decides, and that of torques without noise a thousand: of
sixteen digits, a weaker pull has none left to give what the data do not determine a value, and a
stronger one leaves none to the data.
"""

LEAST_WEIGHT = 1e-12
MOST_WEIGHT = 1e6
