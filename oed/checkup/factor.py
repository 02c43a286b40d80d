"""The factor by which a joint's torque disagrees with those of the others.

Links pass their inertial forces on, so the torques of neighbouring joints need the same masses. A joint
whose torque is a multiple of what it should be spoils that, by any factor: a drive constant, two motors
of which one is logged, a peak value in place of an rms. The likeliest factor of each joint is a suspicion
like all others. Friction and rotors go along with any factor: where a joint moves little beside them no
fit tells its scale, and that is said.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import minimize_scalar

from oed.checkup.change import Change
from oed.checkup.suspicion import UNITS, Suspicion
from oed.checkup.trial import Trials
from oed.experiment.dataset import DataSet

OTHER = 10.0  # a factor that no file, drive constant or gear is uncertain by
FARTHEST = OTHER * max(UNITS)
# Factors that are tried before the likeliest is refined: at one a decade half a torque of the Panda's
# third joint is not found (the recordings of `franka_panda`), at four it is.
PER_DECADE = 4


def likeliest_factors(trials: Trials, dataset: DataSet, change: Change) -> list[Suspicion]:
    """For each joint the factor with which the fit is likeliest, as a further change.

    Args:
        trials: Of the log.
        dataset: As read.
        change: That is made before.
    """
    likelihood = _Likelihood(trials, change)
    decades = np.log10(FARTHEST)
    grid = np.linspace(-decades, decades, int(2 * decades * PER_DECADE) + 1)
    found = []
    for j in range(dataset.robot.n):
        costs = [likelihood.cost(j, 10.0**x) for x in grid]
        best = int(np.clip(np.argmin(costs), 1, len(grid) - 2))
        refined = minimize_scalar(
            lambda x, j=j: likelihood.cost(j, 10.0**x),
            bounds=(grid[best - 1], grid[best + 1]),
            method="bounded",
        )
        found.append(_suspicion(dataset, j, 10.0 ** float(refined.x)))
    return found


def untold(trials: Trials, bar: float) -> tuple[int, ...]:
    """Joints whose torque could be `OTHER` times as large or as small, and the fit would not tell.

    Args:
        trials: Of a log in which no fault was found.
        bar: Twice the logarithm of a likelihood ratio that tells.
    """
    n = trials.model.robot.n
    likelihood = _Likelihood(trials, Change.none(n))
    return tuple(j for j in range(n) if not likelihood.tells(j, bar))


def is_size_told(trials: Trials, change: Change, bar: float) -> bool:
    """Whether the fit tells the sizes of the torques that a change multiplies, each from `OTHER` times it.

    A torque that does not go with those of the others, such as that of a spindle that carries them by
    friction, is fitted best where it outweighs no other: by any factor that is large or small enough.

    Args:
        trials: Of the log.
        change: That repairs the fit.
        bar: Twice the logarithm of a likelihood ratio that tells.
    """
    multiplied = np.flatnonzero(np.abs(change.gain) != 1)
    if not len(multiplied):
        return True
    likelihood = _Likelihood(trials, change)
    return all(likelihood.tells(int(j), bar) for j in multiplied)


class _Likelihood:
    """Of the torques as logged, under a change and one joint's factor."""

    def __init__(self, trials: Trials, change: Change) -> None:
        (self.equations,) = trials.equations([change])
        self.change = change
        self.counts: Float[ndarray, " joints"] = trials.independent(self.equations.fit(change))

    def cost(self, joint: int, factor: float) -> float:
        """Minus twice its logarithm, without what is constant."""
        change = self.change.then(Change.of_torque(len(self.change.gain), joint, factor))
        return self.equations.fit(change, self.counts).deviance(self.counts)

    def tells(self, joint: int, bar: float) -> bool:
        """Whether a joint's torque is likelier by the bar than `OTHER` times it, or as small a part."""
        beside = min(self.cost(joint, factor) for factor in (OTHER, 1 / OTHER))
        return beside - self.cost(joint, 1.0) > bar


def _suspicion(dataset: DataSet, joint: int, factor: float) -> Suspicion:
    name, column = dataset.robot.joint_names[joint], f"tau_{joint + 1}"
    text = (
        f"the torque of {name} ({column}) is {1 / factor:.2g} times what the torques of the other "
        "joints need"
    )
    remedy = f"look for a unit, a gear or a drive constant that multiplies {column} by {factor:.2g}"
    return Suspicion("factor", text, remedy, Change.of_torque(dataset.robot.n, joint, factor))
