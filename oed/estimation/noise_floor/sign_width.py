"""How sharply friction turns where a joint reverses, read off the data.

Below some creeping speed dry friction does not switch but rises with the velocity: grease, and
every simulator's stand-in for the sign, do that, some at once and some by and by. A sign that is
too sharp leaves errors of the size of the friction wherever a joint creeps, and any effect of low
speed will offer to take them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.optimize import minimize_scalar

from oed.dynamics.effects import Coulomb, State
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import sign_terms
from oed.estimation.noise_floor.linear_fit import (
    project,
    reversal_nuisances,
    whitened_regressor,
)
from oed.estimation.noise_floor.weighted_rows import Rows
from oed.experiment.preparation.prepared import Prepared

LARGEST_WIDTH = 0.15  # of the joint's rms velocity: beyond, it is no reversal but a law of speed
# The same where more is missing of the joint: a wide sign may stand in for nearly anything.
MODEST_WIDTH = 0.05
COMPLETE = 2.0  # mean squared white residual up to which little is
SMALLEST_WIDTH = 1e-4
ABSORBED = 1e-4  # share of a column outside the model, below which nothing of it is new
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
    for place, column, sign in sign_terms(model):
        own = np.flatnonzero(columns == column)
        if own.size:
            projection = project(np.delete(regressor, own[0], axis=2))
            left = projection.residual(torque)[sign.joint]
            basis = projection.basis[sign.joint]
            alone = replace(model, effects=(sign,))
            counted = max(float(rows.counted[sign.joint]), 1.0)
            gain = partial(_gain, basis, left)
            turn = Turn(alone, rows, gain, float(np.sum(left**2)), counted)
            effects[place] = turn.best(sign)
    return replace(model, effects=tuple(effects))


def usual_speed(rows: Rows, joint: int) -> float:
    """Root mean square of a joint's velocity [rad/s]: what widths are shares of."""
    velocity = np.concatenate([p.motion.dq[:, joint] for p in rows.prepared])
    return float(np.sqrt(np.mean(velocity**2)))


@dataclass(frozen=True, eq=False)
class Turn:
    """What the rows tell of how one joint's friction turns.

    Attributes:
        alone: A model that has no effect but that friction, and the measurement through which it is seen.
        rows: White rows.
        gain: Fall of the sum of squares by a white column of the joint, beside all that is fitted.
        squares: That sum without friction of the joint.
        counted: Rows of it that count.
    """

    alone: TorqueModel
    rows: Rows
    gain: Callable[[Float[ndarray, " rows"]], float]
    squares: float
    counted: float

    def best(self, sign: Coulomb) -> Coulomb:
        """The term with the turn that gains most, or as it is.

        Args:
            sign: As sharp as it can be.
        """
        scale = usual_speed(self.rows, sign.joint)
        lowest = max(sign.width, SMALLEST_WIDTH * scale)
        for highest in (LARGEST_WIDTH * scale, MODEST_WIDTH * scale):
            if lowest >= highest:
                break
            tried = [
                _best_width(replace(sign, gradual=gradual), self.gain_of, lowest, highest)
                for gradual in (False, True)
            ]
            # What the model lacks is noise to this question.
            noise = max(1.0, (self.squares - max(gain for _, gain in tried)) / self.counted)
            at_once, by_and_by = tried
            best, gained = by_and_by if by_and_by[1] > at_once[1] + noise * DECISIVE else at_once
            if best.width > MODEST_WIDTH * scale and noise > COMPLETE:
                continue
            margin = noise * (DECISIVE + np.log(self.rows.count))
            return best if gained > self.gain_of(sign) + margin else sign
        return sign

    def gain_of(self, tried: Coulomb) -> float:
        """Fall of the sum of squares by the joint's friction with a turn."""
        fine = [_along(tried, self.alone, p) for p in self.rows.prepared]
        return self.gain(self.rows.whiten_fine(fine, tried.joint)[:, 0])


def gain_beside(whole: float, inside: float, moment: float) -> float:
    """Fall of a sum of squares by one more column.

    Args:
        whole: The column's square.
        inside: Of that, what lies in the span of the others.
        moment: Its product with what these leave.
    """
    beside = whole - inside
    return moment**2 / beside if beside > ABSORBED**2 * whole else 0.0


def _gain(
    basis: Float[ndarray, "rows rank"],
    left: Float[ndarray, " rows"],
    column: Float[ndarray, " rows"],
) -> float:
    inside = basis.T @ column
    return gain_beside(float(column @ column), float(inside @ inside), float(column @ left))


def _along(sign: Coulomb, alone: TorqueModel, prepared: Prepared) -> Float[ndarray, "samples 1"]:
    """What a term gives at its own joint, through the measurement of a model where there is one."""
    if alone.measurement:
        model = replace(alone, effects=(sign,))
        return model.columns(prepared.motion)[:, sign.joint]
    (entry,) = sign.entries(State.along(prepared.motion))
    return np.asarray(entry[sign.joint])[:, None]


def _best_width(
    shaped: Coulomb, gain_of: Callable[[Coulomb], float], lowest: float, highest: float
) -> tuple[Coulomb, float]:
    """The term with the width between two that gains most, and how much."""
    width, gained = _peak(lambda w: gain_of(replace(shaped, width=w)), lowest, highest)
    return replace(shaped, width=width), gained


def _peak(gain: Callable[[float], float], lowest: float, highest: float) -> tuple[float, float]:
    """The width between two that gains most, and how much."""
    grid = np.geomspace(lowest, highest, POINTS)
    best = int(np.argmax([gain(float(w)) for w in grid]))
    bounds = np.log(grid[max(best - 1, 0)]), np.log(grid[min(best + 1, POINTS - 1)])
    found = minimize_scalar(
        lambda x: -gain(float(np.exp(x))), bounds=bounds, method="bounded", options={"xatol": 0.02}
    )
    return float(np.exp(found.x)), -float(found.fun)
