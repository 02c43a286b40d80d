"""The motion on which two rival explanations differ most (T-optimality).

Atkinson and Fedorov 1975, "The design of experiments for discriminating between two rival
models", Biometrika 62(1): maximise lambda = min over the rival's parameters of the squared white
distance between its prediction and the favourite's. Two rivals of equal freedom are then confused
with the probability Phi(-sqrt(lambda) / 2); what their shapes and the price of their parameters
change in that is drawn (`oed.diagnosis.rivals.confusion`).

What decides between rivals is the new motion and the recordings at hand together, fitted with
one set of parameters: lambda is that of both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import norm

from oed.diagnosis.candidates.margin import of_smoothing
from oed.diagnosis.rivals.confusion import confusion
from oed.diagnosis.rivals.favourite import Pair, best_imitations, context_beside, torque_beside
from oed.diagnosis.rivals.motions import as_prepared, random_motions
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import score
from oed.diagnosis.terms.secants import shape_derivatives
from oed.diagnosis.terms.trials import Trial, dense, moved
from oed.diagnosis_new.noise.addition import normal_equations
from oed.dynamics.motion import Motion
from oed.experiment.preparation.prepared import Prepared
from oed.parallel_map import side_by_side

# Motions of which the rival is refitted in full: the slope of its shape alone may promise a
# separation that another shape takes back.
REFITTED = 4


@dataclass(frozen=True)
class NextExperiment:
    """A motion that tells rivals apart.

    Attributes:
        motion: One period on the fine grid.
        separation: lambda of the recordings at hand and the new motion, the least over the pairs.
        separation_now: lambda of the recordings at hand.
        error_rate: Predicted chance that the rival is named where the favourite is true, on all
            of these, the largest over the pairs.
        resolved: Predicted chance that the favourite then leads by a decisive difference, the
            least over the pairs.
        error_rate_now: The same on the recordings at hand.
        pairs: Names of the rivals, in words.
        tried: Number of motions that were compared.
        notes: Limits that had to be assumed.
    """

    motion: Motion
    separation: float
    separation_now: float
    error_rate: float
    error_rate_now: float
    resolved: float
    pairs: tuple[str, ...]
    tried: int
    notes: tuple[str, ...]


def design_discriminating(
    shop: Workshop,
    pairs: Sequence[Pair],
    rng: np.random.Generator,
    *,
    candidates: int = 48,
) -> NextExperiment:
    """The best of a number of random motions within the limits.

    Best is where rivals differ most beyond what smoothing may make of their torque. The new
    motion is taken to be run as many times as the first recording's.

    Args:
        shop: The data at hand: model, noise, limits.
        pairs: Favourite, its coefficients, and rival.
        rng: Draws motions.
        candidates: Motions to compare.
    """
    pattern = shop.mean.rows.prepared[0]
    motions, notes = random_motions(shop.baseline.model.robot, pattern, rng, candidates)

    def promised(motion: Motion) -> float:
        further = as_prepared(pattern, motion)
        return min(_slope_clear(shop, pair, further) for pair in pairs)

    def refitted(motion: Motion) -> list[tuple[float, float]]:
        further = as_prepared(pattern, motion)
        return [_gains(shop, pair, further) for pair in pairs]

    order = np.argsort([-clear for clear in side_by_side(promised, motions)], kind="stable")
    leading = [motions[k] for k in order[:REFITTED]]
    gains = side_by_side(refitted, leading)
    best = max(range(len(leading)), key=lambda k: min(map(_clear, pairs, gains[k])))
    motion = leading[best]
    further = as_prepared(pattern, motion)
    foreseen = [confusion(shop, pair, rng, further) for pair in pairs]
    return NextExperiment(
        motion=motion,
        separation=min(max(0.0, own - imitated) for own, imitated in gains[best]),
        separation_now=min(separation(shop, *pair) for pair in pairs),
        error_rate=max(f.by_name for f in foreseen),
        error_rate_now=max(confusion(shop, p, rng).by_name for p in pairs),
        resolved=min(f.resolved for f in foreseen),
        pairs=tuple(_in_words(favourite, rival) for favourite, _, rival in pairs),
        tried=candidates,
        notes=notes,
    )


def error_rate(separation: float) -> float:
    """Chance that noise makes the wrong one of two models without free shapes fit better."""
    return float(norm.cdf(-np.sqrt(max(separation, 0.0)) / 2))


def _in_words(one: Trial, other: Trial) -> str:
    """Two rivals by name, with their joints where the name is the same."""
    if one.name != other.name or one.joint is None or other.joint is None:
        return f"{one.name} or {other.name}"
    return f"{one.name} on joint {one.joint + 1} or on joint {other.joint + 1}"


def separation(
    shop: Workshop,
    favourite: Trial,
    coefficients: Float[ndarray, " columns"],
    rival: Trial,
    further: Prepared | None = None,
) -> float:
    """lambda: what of the favourite's torque no parameters of base model and rival reproduce.

    The rival's shapes are searched over their whole range.

    Args:
        shop: The data at hand, and their noise.
        favourite: The explanation that is taken for true.
        coefficients: Of its columns.
        rival: The other one.
        further: A recording besides those at hand, run as often as the first of these.
    """
    own, imitated = _gains(shop, (favourite, coefficients, rival), further)
    return max(0.0, own - imitated)


def _gains(shop: Workshop, pair: Pair, further: Prepared | None) -> tuple[float, float]:
    """White squares of the favourite's torque, and what the rival's best shape explains of them."""
    fit = torque_beside(shop, pair, further)
    (imitated,) = best_imitations(context_beside(shop, further), pair[2], [fit])
    return fit.squares, imitated.gain


def _clear(pair: Pair, gains: tuple[float, float]) -> float:
    """Lambda less what smoothing may make of the favourite's torque."""
    own, imitated = gains
    return own * (1 - of_smoothing(pair[0], pair[2])) - imitated


def _slope_clear(shop: Workshop, pair: Pair, further: Prepared) -> float:
    """As `_clear`, the rival's shapes to first order about where they are: quick."""
    rival = pair[2]
    fit = torque_beside(shop, pair, further)
    context, joints = context_beside(shop, further), range(shop.context.n)
    own = moved(rival, fit.rows, context)
    linear = dense(own, len(joints), fit.rows.count)
    found = score(own, fit)
    bends = shape_derivatives(own, found.coefficients, fit.rows, context)
    residual = fit.residual
    columns = np.concatenate([linear, bends], axis=2)
    if own.fixed:
        residual, columns = residual - fit.projection.residual(linear.sum(axis=2)), bends
    lost = of_smoothing(pair[0], rival) * fit.squares
    squares = float(np.sum(residual**2))
    if not columns.shape[2]:
        return squares - lost
    group = {j: columns[j] for j in joints}
    return squares - normal_equations(fit.projection, residual, group).solved().gain - lost
