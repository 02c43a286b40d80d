"""How uncertain the parameters of the additions are: noise, shapes and lack of fit together.

Two things are asked of a standard deviation beyond the linear theory. A shape moves its columns
along a curve, with corners where a gear lands or a load is taken up: the slope that counts is the
secant over the shape's own standard deviation. And what the model leaves beyond noise comes again
in the same motion: it is not white, and neighbouring rows err together. The covariance that lets
each block of rows err as it does (Liang and Zeger 1986, Biometrika 73(1), 13-22) is taken where
it is larger than that of the noise.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.candidates.ripening import is_unripe
from oed.diagnosis.evidence.both_motions import narrowed
from oed.diagnosis.evidence.by_recording import rugged_shapes, spread_by_recording
from oed.diagnosis.evidence.common_noise import noise_bias
from oed.diagnosis.evidence.profile import UNIFORM, axes_of, left_by, profiled_deviation, widened
from oed.diagnosis.tables.workbench import Augmented, Layout
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.secants import secants
from oed.diagnosis.terms.trials import Trial, dense, moved
from oed.diagnosis_new.noise.linear_fit import Projection
from oed.dynamics.effects.catalogue import CATALOGUE, Context

# Of a shape's range. Below, differences of filtered columns are rounding; above, no slope is.
STEPS = (1e-5, 0.25)
# The first: of a wave's harmonic any large step is one to another wave, and no slope. A gear's shapes
# have crests, and a profile is not looked at.
FIRST_STEP, FIRST_OF_GEAR = 1e-4, 0.1
ROUNDING = 1e-9  # of a shape's range, below which a deviation is none
ALIKE = 1.2  # ratio of two steps up to which a secant is taken for settled
MOST_ROUNDS = 8


@dataclass(frozen=True)
class _Linearised:
    """A fit in which every shape moves its columns along a secant.

    Attributes:
        columns: White, of base model, nuisances, additions and secants.
        target: What they are to explain.
        projection: On the columns.
        covariance: Of all their parameters.
    """

    columns: Float[ndarray, "joints rows columns"]
    target: Float[ndarray, "joints rows"]
    projection: Projection
    covariance: Float[ndarray, "columns columns"]


def at_given_shapes(
    covariance: Float[ndarray, "parameters parameters"], count: int
) -> Float[ndarray, "columns columns"]:
    """Covariance of an addition's coefficients, its first parameters, with its shapes as they are."""
    given = covariance[:count, count:] @ np.linalg.pinv(covariance[count:, count:])
    return covariance[:count, :count] - given @ covariance[count:, :count]


def with_uncertainty(shop: Workshop, found: Augmented) -> Augmented:
    """The fit with covariances of (coefficients, shapes on their axes) that hold all of this.

    Args:
        shop: The laid-out data.
        found: A fit on the rows of `shop.layout_for` of its additions.
    """
    layout = shop.layout_for(found.chosen)
    places = _places(found, layout)
    steps = [
        np.full(len(t.values), FIRST_OF_GEAR if is_unripe(t) else FIRST_STEP) for t in found.chosen
    ]
    linear = _linearised(shop, found, layout, steps)
    covariance = linear.covariance
    widest = np.sqrt(np.diag(covariance))
    for _ in range(MOST_ROUNDS):
        deviations = np.sqrt(np.diag(covariance))
        wanted = [
            np.clip(deviations[p][p.stop - p.start - len(s) :], *STEPS)
            for p, s in zip(places, steps, strict=True)
        ]
        pairs = zip(wanted, steps, strict=True)
        if all(np.all(np.abs(np.log(w / s)) < np.log(ALIKE)) for w, s in pairs):
            break
        steps = wanted
        linear = _linearised(shop, found, layout, steps)
        covariance = linear.covariance
        widest = np.maximum(widest, np.sqrt(np.diag(covariance)))
    else:
        # Teeth that strike have no slope that settles: the flattest secant is the one to trust.
        last = np.sqrt(np.diag(covariance))
        scale = widest / np.where(last > 0, last, np.inf)
        covariance = covariance * np.outer(scale, scale)
    covariance = _profiled(shop, found, linear, steps, covariance)
    if layout is shop.mean:
        bias = noise_bias(
            shop,
            lambda own: _columns(shop, found, own, steps),
            linear.projection.inverse @ linear.projection.coordinates(linear.target),
            linear.projection,
        )
        covariance = covariance + np.outer(bias, bias)
    for k, trial in enumerate(found.chosen):
        if trial.decided:
            covariance = _with_unseen(shop, found, steps, covariance, k)
    covariance = _as_recordings_differ(shop, found, places, covariance)
    return dataclasses.replace(found, covariances=tuple(covariance[p, p] for p in places))


def _profiled(
    shop: Workshop,
    found: Augmented,
    linear: _Linearised,
    steps: Sequence[Float[ndarray, " _"]],
    covariance: Float[ndarray, "columns columns"],
) -> Float[ndarray, "columns columns"]:
    """The covariance with shapes as uncertain as a fit with all else free shows them to be.

    A gear is left out: its gain has crests, and takes as long to evaluate as all others.
    """
    layout, target = shop.layout_for(found.chosen), linear.target
    alone = np.sum(linear.projection.inverse**2, axis=1)
    for trial, place, step in zip(found.chosen, _places(found, layout), steps, strict=True):
        if not trial.shapes or is_unripe(trial):
            continue
        own = moved(trial, layout.rows, shop.context)
        rest = np.delete(linear.columns, place, axis=2)
        others = layout.span.extended(rest[:, :, _base(layout) :])
        whole = target + dense(own, *target.shape).sum(axis=2) if own.fixed else target
        squares = left_by(own, others, whole, layout.rows, shop.context, steps=step)
        first = place.stop - len(trial.values)
        for k, axis in axes_of(trial, shop.context):
            at = first + k
            deviation = float(np.sqrt(covariance[at, at]))
            # What the fit leaves out has no deviation but rounding.
            if not ROUNDING < deviation < UNIFORM:
                continue
            noise = float(covariance[at, at] / alone[at])
            wide = profiled_deviation(partial(squares, k), axis, deviation, noise)
            covariance = widened(covariance, at, wide / deviation)
    return covariance


def _with_unseen(
    shop: Workshop,
    found: Augmented,
    steps: Sequence[Float[ndarray, " _"]],
    covariance: Float[ndarray, "columns columns"],
    number: int,
) -> Float[ndarray, "columns columns"]:
    """The covariance with what the validation recordings tell of the shapes of one addition."""
    unseen, seen = shop.unseen_by(found.chosen), shop.layout_for(found.chosen)
    if unseen.rows is None:
        return covariance
    nuisances = np.zeros((*unseen.white.shape[:2], seen.nuisances.shape[2]))
    layout = Layout(unseen.rows, unseen.white, nuisances, unseen.rows.torque())
    misfit = np.maximum(unseen.left(found) / unseen.counted, 1.0)
    place = _places(found, seen)[number]
    own = slice(place.stop - len(found.chosen[number].values), place.stop)
    narrow, steps = covariance, list(steps)
    for _ in range(MOST_ROUNDS):
        columns, _ = _columns(shop, found, layout, steps)
        slopes = columns.reshape(-1, columns.shape[2])
        narrow = narrowed(covariance, own, slopes, np.repeat(misfit, columns.shape[1]))
        wanted = np.clip(np.sqrt(np.diag(narrow)[own]), *STEPS)
        if np.all(np.abs(np.log(wanted / steps[number])) < np.log(ALIKE)):
            break
        steps[number] = wanted
    return narrow


def _as_recordings_differ(
    shop: Workshop,
    found: Augmented,
    places: Sequence[slice],
    covariance: Float[ndarray, "columns columns"],
) -> Float[ndarray, "columns columns"]:
    """The covariance with shapes that have crests at least as uncertain as recordings differ."""
    for number, (trial, place) in enumerate(zip(found.chosen, places, strict=True)):
        for k in rugged_shapes(trial, shop.context):
            at = place.stop - len(trial.values) + k
            deviation = float(np.sqrt(covariance[at, at]))
            if deviation > ROUNDING:
                spread = spread_by_recording(shop, found, number, k)
                covariance = widened(covariance, at, max(1.0, spread / deviation))
    return covariance


def _linearised(
    shop: Workshop, found: Augmented, layout: Layout, steps: Sequence[Float[ndarray, " _"]]
) -> _Linearised:
    """The fit with secants over these steps."""
    columns, target = _columns(shop, found, layout, steps)
    projection = layout.span.extended(columns[:, :, _base(layout) :])
    covariance = robust_covariance(
        projection, projection.residual(target), layout.rows.counted, layout.rows.blocks()
    )
    return _Linearised(columns, target, projection, covariance)


def _columns(
    shop: Workshop, found: Augmented, layout: Layout, steps: Sequence[Float[ndarray, " _"]]
) -> tuple[Float[ndarray, "joints rows columns"], Float[ndarray, "joints rows"]]:
    """White columns of base model, nuisances and additions on a layout, and their target."""
    joints, count, _ = layout.regressor.shape
    blocks, target = [layout.regressor, layout.nuisances], layout.torque.copy()
    for trial, coefficients, step in zip(found.chosen, found.coefficients, steps, strict=True):
        own = moved(trial, layout.rows, shop.context)
        columns = dense(own, joints, count)
        if trial.fixed:
            target -= columns.sum(axis=2)
        else:
            blocks.append(columns)
        moving = secants(trial, coefficients, layout.rows, shop.context, step)
        blocks.append(moving * _estimated(trial, shop.context))
    return np.concatenate(blocks, axis=2), target


def _estimated(trial: Trial, context: Context) -> Float[ndarray, " shapes"]:
    """One for each shape of an addition, zero for those that its plain formula does not have."""
    if not trial.values:
        return np.ones(0)
    shapes = CATALOGUE[trial.name].shapes_for(context, trial.target)
    pairs = zip(trial.values, shapes, strict=True)
    return np.array([0.0 if shape.is_plain(value) else 1.0 for value, shape in pairs])


def _base(layout: Layout) -> int:
    """Columns that every fit to a layout shares: base model and nuisances."""
    return layout.regressor.shape[2] + layout.nuisances.shape[2]


def _places(found: Augmented, layout: Layout) -> list[slice]:
    """Where the parameters of each addition stand: coefficients unless fixed, then shapes."""
    start, places = _base(layout), []
    for trial in found.chosen:
        size = len(trial.values) + (0 if trial.fixed else len(trial.effect.parameters))
        places.append(slice(start, start + size))
        start += size
    return places


def robust_covariance(
    projection: Projection,
    residual: Float[ndarray, "joints rows"],
    counted: Float[ndarray, " joints"],
    blocks: Int[ndarray, " rows"],
) -> Float[ndarray, "parameters parameters"]:
    """Covariance of a fit to white rows, each variance the larger of the noise's and the blocks'.

    Args:
        projection: Of the regressor; its inverse gives the parameters of interest.
        residual: White residual, of unit variance if nothing but noise is left.
        counted: (n,) rows of each joint that count.
        blocks: Number of the block of each row; blocks err independently.
    """
    freedom = max(float(np.sum(counted)) - projection.rank, 1.0)
    inflation = max(1.0, float(np.sum(residual**2)) / freedom)
    noise = inflation * projection.inverse @ projection.inverse.T
    scores = np.zeros((int(blocks.max()) + 1, projection.rank))
    np.add.at(scores, blocks, np.einsum("jrb,jr->rb", projection.basis, residual, optimize=True))
    # A fit takes its share of what the rows err: as for the mean square.
    share = len(scores) / max(len(scores) - 1, 1) * (1 + projection.rank / freedom)
    by_block = share * np.sum((scores @ projection.inverse.T) ** 2, axis=0)
    own = np.diag(noise)
    scale = np.sqrt(np.maximum(by_block / np.where(own > 0, own, np.inf), 1.0))
    return noise * np.outer(scale, scale)
