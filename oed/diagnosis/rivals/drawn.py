"""A candidate fitted to many drawn torques at once, over all its shapes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.terms.trials import Trial, catalogue_trial, grid_of
from oed.diagnosis_new.noise.addition import normal_equations
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.context import Context

NEARBY = np.array([-1.0, -0.5, -0.25, 0.25, 0.5, 1.0])  # of a grid's step, around a fitted shape
# The same where the combinations of more shapes would be too many to try.
FEW_SHAPES, FEW_NEARBY = 3, np.array([-0.25, 0.25])


@dataclass(frozen=True)
class Drawn:
    """The best shape of a candidate, for each of many draws.

    Attributes:
        trials: With all shapes that were tried.
        index: (draws,) of the best of them.
        gain: (draws,) its fall of the sum of squares.
        evidence: (draws,) less what it cost.
        freedom: (draws,) parameters.
        cancelled: (draws,) ratio of its own squares to its gain.
    """

    trials: Sequence[Trial]
    index: Int[ndarray, " draws"]
    gain: Float[ndarray, " draws"]
    evidence: Float[ndarray, " draws"]
    freedom: Float[ndarray, " draws"]
    cancelled: Float[ndarray, " draws"]

    def chosen(self) -> list[Trial]:
        """The best trial of every draw."""
        return [self.trials[k] for k in self.index]


def noise_beside(
    fit: LinearFit, rng: np.random.Generator, draws: int
) -> Float[ndarray, "joints rows draws"]:
    """White noise outside a model: the part within it is lost to all candidates."""
    white = rng.standard_normal((*fit.residual.shape, draws))
    noise = np.stack([fit.rows.as_certain(own, joint) for joint, own in enumerate(white)])
    inside = np.einsum("jrb,jrd->bd", fit.projection.basis, noise, optimize=True)
    noise -= np.einsum("jrb,bd->jrd", fit.projection.basis, inside, optimize=True)
    return noise


def best_of_shapes(
    context: Context,
    candidates: Sequence[Trial],
    fit: LinearFit,
    torque: Float[ndarray, "joints rows draws"],
    count: float,
) -> Drawn:
    """Of each draw the shape that gains most.

    Args:
        context: What is known.
        candidates: One with some shapes, around which the search is finer.
        fit: The model beside which it stands.
        torque: White, without a part within that model.
        count: Rows that its parameters are charged for.
    """
    trials = list(_around(candidates, fit, context))
    # (4, draws): gain, evidence, freedom, cancelled.
    best, index = _judged(trials[0], fit, torque, count), np.zeros(torque.shape[2], dtype=int)
    for k, trial in enumerate(trials[1:], start=1):
        new = _judged(trial, fit, torque, count)
        better = new[0] > best[0]
        best, index = np.where(better, new, best), np.where(better, k, index)
    return Drawn(trials, index, *best)


def _judged(
    trial: Trial, fit: LinearFit, torque: Float[ndarray, "joints rows draws"], count: float
) -> Float[ndarray, "4 draws"]:
    """What `oed.diagnosis.terms.scores.score` has for one, of many torques at once."""
    normal = normal_equations(fit.projection, fit.residual, trial.group)
    # The drawn torque has no part within the model, so that the columns need no projection.
    moments = np.sum([b.T @ torque[joint] for joint, b in trial.group.items()], axis=0)
    ones = np.ones(torque.shape[2])
    if trial.fixed:
        gains = 2 * moments.sum(axis=0) - normal.gram.sum()
        return np.stack([gains, gains - trial.shapes * np.log(count), trial.shapes * ones, ones])
    directions = normal.directions
    gains, coefficients = directions.gains(moments), directions.coefficients(moments)
    own = sum(np.sum((b @ coefficients) ** 2, axis=0) for b in trial.group.values())
    cancelled = np.maximum(own / np.maximum(gains, 1e-300), 1.0)
    freedom = int(directions.rank) + trial.shapes
    charged = freedom * np.log(count) + len(coefficients) * np.log(cancelled)
    return np.stack([gains, gains - charged, freedom * ones, cancelled])


def _around(candidates: Sequence[Trial], fit: LinearFit, context: Context) -> Iterator[Trial]:
    """A candidate over the grid of its shapes, and more finely around its own; its formula as it is.

    More terms always gain more; a search asks for evidence before it takes them.
    """
    first = candidates[0]
    entry = CATALOGUE[first.name]
    shapes = entry.shapes_for(context, first.target)
    values = {c.values for c in candidates} | set(grid_of(shapes) if shapes else ())
    nearby = NEARBY if len(shapes) <= FEW_SHAPES else FEW_NEARBY
    axes = []
    for value, shape in zip(first.values, shapes, strict=True):
        if shape.scale == "formula":
            axes.append([value])
            continue
        near = shape.place_of(value) + nearby / max(shape.points - 1, 1)
        axes.append([value, *(shape.at(float(x)) for x in near if 0 <= x <= 1)])
    values |= set(product(*axes))
    for v in sorted(values):
        yield catalogue_trial(entry, context, first.target, v, fit.rows)
