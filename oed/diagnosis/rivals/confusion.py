"""How often noise makes the wrong one of two rivals win, refitted with all their shapes.

Phi(-sqrt(lambda) / 2) (Atkinson and Fedorov 1975) is the chance of a wrong choice between two
models that have nothing to fit. A rival whose shapes are searched over a wide range fits noise
besides, and the diagnosis names by evidence, which charges for every parameter. So the
favourite's torque is drawn with noise many times, both are fitted, and the wrong ones counted
(a parametric bootstrap; Efron and Tibshirani 1993, section 6.5).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.data.prepared import Prepared
from oed.diagnosis.fit.addition import normal_equations
from oed.diagnosis.fit.linear_fit import LinearFit
from oed.diagnosis.fit.rows import Rows
from oed.diagnosis.search.scan import Score, refine, score
from oed.diagnosis.search.workbench import Layout, fit_layout, layout_of
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.shape_axes import from_axis, to_axis
from oed.diagnosis.terms.trials import Trial, catalogue_trial, dense, grid_of, white_group
from oed.dynamics.effects.catalogue import CATALOGUE

DRAWS = 400  # of the noise: a rate of 10 % is known within 1.5 points
NEARBY = np.array([-1.0, -0.5, -0.25, 0.25, 0.5, 1.0])  # of a grid's step, around a fitted shape
# The same where the combinations of more shapes would be too many to try.
FEW_SHAPES, FEW_NEARBY = 3, np.array([-0.25, 0.25])

# Favourite, its coefficients, and rival.
Pair = tuple[Trial, Float[ndarray, " columns"], Trial]


@dataclass(frozen=True)
class Confusion:
    """Predicted chances that noise makes the rival win where the favourite is true.

    Attributes:
        by_fit: Of a better fit, whatever it cost.
        by_name: Of more evidence, as the diagnosis names.
    """

    by_fit: float
    by_name: float


def confusion(
    shop: Workshop,
    pair: Pair,
    rng: np.random.Generator,
    further: Prepared | None = None,
    *,
    draws: int = DRAWS,
) -> Confusion:
    """Draw the favourite's torque with noise, fit both rivals, and count.

    Args:
        shop: The data at hand, and their noise.
        pair: Favourite, its coefficients, and rival.
        rng: Of the noise.
        further: A recording besides those at hand, run as often as the first of these.
        draws: Of the noise.
    """
    fit = torque_beside(shop, pair, further)
    white = rng.standard_normal((*fit.residual.shape, draws))
    noise = np.stack([fit.rows.as_certain(own, joint) for joint, own in enumerate(white)])
    # The part of the noise within the model is lost to both.
    inside = np.einsum("jrb,jrd->bd", fit.projection.basis, noise, optimize=True)
    noise -= np.einsum("jrb,bd->jrd", fit.projection.basis, inside, optimize=True)
    drawn = fit.residual[:, :, None] + noise
    count = shop.full.rows.count * fit.rows.count / shop.layout_for([pair[0], pair[2]]).rows.count
    # What explains the favourite's torque best is not what explains the measured one best, and a
    # shape that misses it by a step of the grid may lose more than noise could make up for.
    rival = best_imitation(shop, pair[2], fit).trial
    own, other = (_best(_around(shop, t, fit), fit, drawn, count) for t in (pair[0], rival))
    return Confusion(float(np.mean(other[0] > own[0])), float(np.mean(other[1] > own[1])))


def best_imitation(shop: Workshop, rival: Trial, fit: LinearFit) -> Score:
    """The rival with the shape that explains a favourite's torque best, of their whole range.

    Args:
        shop: The data at hand, and their noise.
        rival: With the shape that explains the data.
        fit: Of the favourite's torque, by `torque_beside`.
    """
    entry, context = CATALOGUE[rival.name], shop.context
    shapes = entry.shapes_for(context, rival.target)
    values = [rival.values, *grid_of(shapes)] if shapes else [rival.values]
    tried = (catalogue_trial(entry, context, rival.target, v, fit.rows) for v in values)
    scores = [score(trial, fit) for trial in tried]
    # From where the rival stands, and from the best of the grid: there is more than one valley.
    starts = {s.trial.values: s for s in (scores[0], max(scores, key=lambda s: s.gain))}
    return max((refine(s, fit, context) for s in starts.values()), key=lambda s: s.gain)


def _best(
    trials: Iterable[Trial],
    fit: LinearFit,
    drawn: Float[ndarray, "joints rows draws"],
    count: float,
) -> tuple[Float[ndarray, " draws"], Float[ndarray, " draws"]]:
    """Largest gain of a candidate over its shapes, and the evidence of that shape."""
    gain = np.full(drawn.shape[2], -np.inf)
    evidence = gain.copy()
    for trial in trials:
        new, charged = _gains(trial, fit, drawn, count)
        evidence = np.where(new > gain, charged, evidence)
        gain = np.maximum(new, gain)
    return gain, evidence


def _gains(
    trial: Trial, fit: LinearFit, drawn: Float[ndarray, "joints rows draws"], count: float
) -> tuple[Float[ndarray, " draws"], Float[ndarray, " draws"]]:
    """Gain and evidence as `oed.diagnosis.search.scan.score` has them, of many torques at once."""
    normal = normal_equations(fit.projection, fit.residual, trial.group)
    # The drawn torque has no part within the model, so that the columns need no projection.
    moments = np.sum([b.T @ drawn[joint] for joint, b in trial.group.items()], axis=0)
    if trial.fixed:
        gains = 2 * moments.sum(axis=0) - normal.gram.sum()
        return gains, gains - trial.shapes * np.log(count)
    directions = normal.directions()
    gains, coefficients = directions.gains(moments), directions.coefficients(moments)
    own = sum(np.sum((b @ coefficients) ** 2, axis=0) for b in trial.group.values())
    cancelled = np.maximum(own / np.maximum(gains, 1e-300), 1.0)
    charged = (directions.rank + trial.shapes) * np.log(count)
    return gains, gains - charged - len(coefficients) * np.log(cancelled)


def _around(shop: Workshop, trial: Trial, fit: LinearFit) -> Iterator[Trial]:
    """A candidate over the grid of its shapes, and more finely around its own; its formula as it is.

    More terms always gain more; a search asks for evidence before it takes them.
    """
    entry, context = CATALOGUE[trial.name], shop.context
    shapes = entry.shapes_for(context, trial.target)
    values = {trial.values, *grid_of(shapes)} if shapes else {trial.values}
    axes, nearby = [], NEARBY if len(shapes) <= FEW_SHAPES else FEW_NEARBY
    for value, shape in zip(trial.values, shapes, strict=True):
        if shape.scale == "formula":
            axes.append([value])
            continue
        here = to_axis(value, shape)
        near = here + nearby / max(shape.points - 1, 1)
        axes.append([value, *(from_axis(float(x), shape) for x in near if 0 <= x <= 1)])
    values |= set(product(*axes))
    for v in sorted(values):
        yield catalogue_trial(entry, context, trial.target, v, fit.rows)


def torque_beside(shop: Workshop, pair: Pair, further: Prepared | None) -> LinearFit:
    """The favourite's white torque, fitted with base model and nuisances alone.

    Args:
        shop: The data at hand, and their noise.
        pair: Favourite, its coefficients, and rival.
        further: A recording besides those at hand, run as often as the first of these.
    """
    favourite, coefficients, rival = pair
    layout = _with_further(shop, shop.layout_for([favourite, rival]), further)
    # The effect as it was fitted: one that acts on the model's torque brings its own.
    mine = dataclasses.replace(favourite, group=white_group(favourite.effect, layout.rows))
    torque = dense(mine, shop.context.n, layout.rows.count) @ coefficients
    return fit_layout(shop.baseline, layout, [], torque)


def _with_further(shop: Workshop, layout: Layout, further: Prepared | None) -> Layout:
    """A layout and one more recording."""
    if further is None:
        return layout
    old, scale = layout.rows, layout.rows.scales[0]
    new = layout_of(shop.baseline, shop.baseline.rows((further,), (scale,)))
    weights = np.concatenate([old.weights, new.rows.weights])
    hidden = (*old.hidden, *new.rows.hidden)
    rows = Rows((*old.prepared, further), old.noise, (*old.scales, scale), weights, hidden)
    blocks = (
        (layout.regressor, new.regressor),
        (layout.nuisances, new.nuisances),
        (layout.torque, new.torque),
    )
    return Layout(rows, *(np.concatenate(pair, axis=1) for pair in blocks))
