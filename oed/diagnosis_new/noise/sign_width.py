"""How sharply friction turns where a joint reverses, read off the data.

Below some creeping speed dry friction does not switch but rises with the velocity: grease, and
every simulator's stand-in for the sign, do that, some at once and some by and by. A sign that is
too sharp leaves errors of the size of the friction wherever a joint creeps, and any effect of low
speed will offer to take them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.optimize import minimize_scalar

from oed.diagnosis_new.noise.addition import normal_equations
from oed.diagnosis_new.noise.linear_fit import (
    Projection,
    project,
    reversal_nuisances,
    whitened_regressor,
)
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects import Coulomb, with_columns
from oed.dynamics.torque_model import TorqueModel

# tanh(v / width) is closest to the expected sign of a Gaussian velocity at this many sigmas.
WIDTH_PER_SIGMA = 1.25
LARGEST_WIDTH = 0.15  # of the joint's rms velocity: beyond, it is no reversal but a law of speed
# The same where more is missing of the joint: a wide sign may stand in for nearly anything.
MODEST_WIDTH = 0.05
COMPLETE = 2.0  # mean squared white residual up to which little is
SMALLEST_WIDTH = 1e-4
WIDER = 1.1  # ratio of two widths beyond which they are not alike
POINTS = 14
# Fall of -2 log likelihood that a wider sign must bring, besides Schwarz's log of the rows.
DECISIVE = 10.0


def with_fitted_sign(
    model: TorqueModel,
    columns: Int[ndarray, " parameters"],
    rows: Rows,
    beside: Float[ndarray, "joints rows additions"] | None = None,
) -> TorqueModel:
    """The model whose Coulomb terms turn over the velocities that fit best, joint by joint.

    Widths stay as they are where the data show no better one.

    Args:
        model: With a Coulomb term for each joint, or for some.
        columns: Of its columns that are estimated.
        rows: White rows.
        beside: White columns of what else is fitted.
    """
    fixed = [whitened_regressor(model, columns, rows), reversal_nuisances(rows)]
    regressor = np.concatenate([*fixed, *([] if beside is None else [beside])], axis=2)
    torque = rows.torque()
    effects = list(model.effects)
    for place, (effect, at) in enumerate(with_columns(model.effects)):
        own = np.flatnonzero(columns == at.start)
        if not isinstance(effect, Coulomb) or not own.size:
            continue
        projection = project(np.delete(regressor, own[0], axis=2))
        alone = dataclasses.replace(model, effects=(effect,))
        effects[place] = _best_turn(alone, rows, projection, projection.residual(torque))
    return dataclasses.replace(model, effects=tuple(effects))


def widths_of(model: TorqueModel) -> list[float]:
    """Width of each Coulomb term [rad/s]."""
    return [effect.width for effect in _coulomb_terms(model)]


def turn_alike(one: TorqueModel, other: TorqueModel) -> bool:
    """Whether the Coulomb terms of two models turn alike, by shape and about by width."""
    pairs = zip(_coulomb_terms(one), _coulomb_terms(other), strict=True)
    return all(
        a.gradual == b.gradual and max(a.width, b.width) < WIDER * max(min(a.width, b.width), 1e-12)
        for a, b in pairs
    )


def usual_speed(rows: Rows, joint: int) -> float:
    """Root mean square of a joint's velocity [rad/s]: what widths are shares of."""
    velocity = np.concatenate([p.motion.dq[:, joint] for p in rows.prepared])
    return float(np.sqrt(np.mean(velocity**2)))


def _coulomb_terms(model: TorqueModel) -> list[Coulomb]:
    return [effect for effect in model.effects if isinstance(effect, Coulomb)]


def signs_of(model: TorqueModel) -> dict[int, Coulomb]:
    """The Coulomb term of each joint that has one."""
    return {effect.joint: effect for effect in _coulomb_terms(model)}


def with_uncertain_sign(model: TorqueModel, sign_noise: Float[ndarray, " joints"]) -> TorqueModel:
    """The model whose Coulomb friction is the expectation over an uncertain velocity sign.

    Only the sign's own noise enters: a velocity shrunk like a regressor would shift it.
    """
    least = WIDTH_PER_SIGMA * sign_noise
    blurred = (
        dataclasses.replace(sign, width=max(sign.width, float(least[sign.joint])))
        for sign in _coulomb_terms(model)
    )
    return with_signs(model, {sign.joint: sign for sign in blurred})


def with_signs(model: TorqueModel, signs: Mapping[int, Coulomb]) -> TorqueModel:
    """The model with these Coulomb terms in the place of those of the same joints."""
    effects = (signs.get(e.joint, e) if isinstance(e, Coulomb) else e for e in model.effects)
    return dataclasses.replace(model, effects=tuple(effects))


def with_widths(model: TorqueModel, widths: Sequence[float]) -> TorqueModel:
    """The model whose Coulomb terms turn over these velocities [rad/s], in their order."""
    pairs = zip(_coulomb_terms(model), widths, strict=True)
    turned = (dataclasses.replace(sign, width=width, gradual=False) for sign, width in pairs)
    return with_signs(model, {sign.joint: sign for sign in turned})


def _best_turn(
    alone: TorqueModel, rows: Rows, projection: Projection, residual: Float[ndarray, "joints rows"]
) -> Coulomb:
    """The one term of a model with the turn that gains most, or its own."""
    (effect,) = alone.effects
    if not isinstance(effect, Coulomb):
        raise TypeError(f"{effect.name} has no sign whose width could be fitted")
    joint = effect.joint

    def gain_of(tried: Coulomb) -> float:
        model = dataclasses.replace(alone, effects=(tried,))
        fine = [model.columns(p.motion)[:, joint] for p in rows.prepared]
        group = {joint: rows.whiten_fine(fine, joint)}
        return normal_equations(projection, residual, group).solved().gain

    scale = usual_speed(rows, joint)
    lowest = max(effect.width, SMALLEST_WIDTH * scale)
    squares = float(np.sum(residual[joint] ** 2))
    weight = max(float(rows.counted[joint]), 1.0)
    for highest in (LARGEST_WIDTH * scale, MODEST_WIDTH * scale):
        if lowest >= highest:
            break
        tried = [
            _best_width(dataclasses.replace(effect, gradual=gradual), gain_of, lowest, highest)
            for gradual in (False, True)
        ]
        # What the model lacks is noise to this question.
        noise = max(1.0, (squares - max(gain for _, gain in tried)) / weight)
        at_once, by_and_by = tried
        best, gained = by_and_by if by_and_by[1] > at_once[1] + noise * DECISIVE else at_once
        if best.width > MODEST_WIDTH * scale and noise > COMPLETE:
            continue
        margin = noise * (DECISIVE + np.log(rows.count))
        return best if gained > gain_of(effect) + margin else effect
    return effect


def _best_width(
    shaped: Coulomb, gain_of: Callable[[Coulomb], float], lowest: float, highest: float
) -> tuple[Coulomb, float]:
    """The term with the width between two that gains most, and how much."""
    width, gained = _peak(lambda w: gain_of(dataclasses.replace(shaped, width=w)), lowest, highest)
    return dataclasses.replace(shaped, width=width), gained


def _peak(gain: Callable[[float], float], lowest: float, highest: float) -> tuple[float, float]:
    """The width between two that gains most, and how much."""
    grid = np.geomspace(lowest, highest, POINTS)
    best = int(np.argmax([gain(float(w)) for w in grid]))
    bounds = np.log(grid[max(best - 1, 0)]), np.log(grid[min(best + 1, POINTS - 1)])
    found = minimize_scalar(
        lambda x: -gain(float(np.exp(x))), bounds=bounds, method="bounded", options={"xatol": 0.02}
    )
    return float(np.exp(found.x)), -float(found.fun)
