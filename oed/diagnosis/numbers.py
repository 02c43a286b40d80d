"""The numbers of the method, each with its reason; those that no study has set yet say "assumed"."""

# Evidence.
BASE_ERROR = 0.002  # share of a base torque that may be left without blame; assumed, not measured
FORMULA_ERROR = 0.03  # the same of an added term: formulas are true to a few per cent; assumed
BLOCK_SECONDS = 0.5  # [s] least length of a block: friction at two reversals is two observations
MOST_BLOCK_SHARE = (
    1 / 12
)  # of the rows: fewer blocks leave no estimate of a score's variance; assumed
SMOOTHNESS = (1e-6, 1e-4, 1e-2, 1e0, 1e2)  # rows' worth of a prior on differences of neighbours

# Selection.
PREDICTION_GAIN = (
    1.0  # nats by which a held-out score must rise: one parameter's cost (Akaike 1974)
)
TESTED = 0.5  # of a term's degrees of freedom that held-out rows must see; assumed
POLISHED = 8  # candidates whose shapes are fitted before they are compared
COMPARED = 4  # of these that are fitted beside all else
EFFECTS_PER_JOINT, LEAST_EFFECTS = 3, 6  # terms; assumed
HELD_OUT_SHARE = 0.25  # of a recording's end, where no validation recording was made
ROUNDS = 3  # of refitting variances, and effects of the model's own torque (converges as the effect's share)

# Inference.
NAMED = 0.95  # least posterior probability of a name: one in twenty may be wrong
CLEAR = 2.0  # noise floors of held-out error from which a joint counts as unexplained
ALIKE = 1 - FORMULA_ERROR**2 / 2  # cosine of torques that differ by less than formulas err
MOSTLY = (
    0.5  # of the variance left at a joint, from which on one line or one moment is what is left
)
SHORTLY = 0.05  # of all recordings' time, that a moment takes at most; assumed
REPLICATES = 400  # of the block bootstrap: an interval's end is known within a tenth of its width
LOOKS = 2  # ahead and back; what was dropped may have kept something out, once; assumed
EXCHANGES = 6  # rounds in which terms give way to what is better in their place; assumed
OUTSIDE = 0.05  # prior odds of an effect outside the catalogue against one in it; assumed
NOISE_LAGS = 4  # of a control loop's answer to noise, a quarter of the band's period apart
SETTLING = 3  # rounds of shapes one after another: more change the score by less than a nat

# Discrimination.
REFITTED = 4  # motions on which the alternative is refitted with its shapes; assumed
