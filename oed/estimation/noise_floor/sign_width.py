"""How sharply friction turns where a joint reverses, read off the data.

Below some creeping speed dry friction does not switch but rises with the velocity: grease, and
every simulator's stand-in for the sign, do that, some at once and some by and by. A sign that is
too sharp leaves errors of the size of the friction wherever a joint creeps, and any effect of low
speed will offer to take them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.optimize import minimize_scalar

from oed.dynamics.effects import Coulomb, State
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import sign_terms
from oed.estimation.noise_floor.linear_fit import span_of_model
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
    model: TorqueModel, columns: Int[ndarray, " parameters"], rows: Rows
) -> TorqueModel:
    """The model whose Coulomb terms turn over the velocities that fit best, joint by joint.

    Widths stay as they are where the data show no better one.

    Args:
        model: With a Coulomb term for each joint, or for some.
        columns: Of its columns that are estimated.
        rows: White rows.
    """
    span, torque = span_of_model(model, columns, rows), rows.torque()
    sizes, left = span.inverse @ span.coordinates(torque), span.residual(torque)
    effects = list(model.effects)
    for place, column, sign in sign_terms(model):
        own = np.flatnonzero(columns == column)
        if own.size:
            j, number = sign.joint, int(own[0])
            others = Others.of(span.basis[j], left[j], span.inverse[number], float(sizes[number]))
            alone = replace(model, effects=(sign,))
            counted = max(float(rows.counted[j]), 1.0)
            turn = Turn(alone, rows, others.gain, others.squares, counted)
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


@dataclass(frozen=True, eq=False)
class Others:
    """All columns of a fit but one, on the rows of one joint: the fit's span less one direction.

    Attributes:
        basis: (R, b) of the whole span.
        left: (R,) what all columns leave.
        direction: (b,) of what the column adds to the others, of unit length.
        size: Of the torque along it.
    """

    basis: Float[ndarray, "rows rank"]
    left: Float[ndarray, " rows"]
    direction: Float[ndarray, " rank"]
    size: float

    @classmethod
    def of(
        cls,
        basis: Float[ndarray, "rows rank"],
        left: Float[ndarray, " rows"],
        inverse: Float[ndarray, " rank"],
        coefficient: float,
    ) -> Others:
        """All but one.

        Args:
            basis: As above; likewise left.
            left: What all columns leave.
            inverse: The column's row of that by which coordinates in the basis give coefficients.
            coefficient: The column's.
        """
        length = float(np.linalg.norm(inverse)) or np.inf  # a column of zeros adds no direction
        return cls(basis, left, inverse / length, coefficient / length)

    @property
    def squares(self) -> float:
        """Sum of squares that the others leave."""
        return float(np.sum((self.left + self.basis @ self.direction * self.size) ** 2))

    def gain(self, column: Float[ndarray, " rows"]) -> float:
        """Fall of that sum by another column in the place of the one."""
        inside = self.basis.T @ column
        along = float(inside @ self.direction)
        whole = float(column @ column)
        new = whole - (float(inside @ inside) - along**2)
        moment = float(column @ self.left) + along * self.size
        return moment**2 / new if new > ABSORBED**2 * whole else 0.0


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
