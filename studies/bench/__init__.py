"""The undeclared-effect bench: is what the diagnosis says true?

Arms are simulated with effects that the data set does not mention; the diagnosis is run on the
data sets as a black box, and its answer is held against the truth. The hidden effects are written
here from their physics, without the formulas of `oed.dynamics.effects`.
"""
