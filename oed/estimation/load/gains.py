"""How many newton metres an ampere is, joint by joint, from loads that are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats

from oed.dynamics.motion import random_motion
from oed.estimation.load.consistent_gains import ConsistentArm, consistent_arm
from oed.estimation.load.current_equations import CurrentEquations
from oed.estimation.load.gain_fit import GainFit, fit_gains, reference_joint
from oed.estimation.load.quantities import LEVEL

# Makers' constants are trusted to 10 or 15 per cent: an interval as wide tells nothing new.
WIDEST = 0.10  # relative half width of an interval that is still told
STATES = 200
FELT = 1e-6  # of the largest torque by the load, below which a joint does not feel it


@dataclass(frozen=True)
class Gain:
    """What is known of one joint's gain.

    Attributes:
        joint: Its name.
        value: N m (N at a slide) per A, or its ratio to the reference joint's; None where nothing
            tells it.
        interval: At 95 %; None with the value.
        reason: Why there is none; empty where there is.
    """

    joint: str
    value: float | None
    interval: tuple[float, float] | None
    reason: str = ""


@dataclass(frozen=True)
class Gains:
    """The gains of an arm.

    Attributes:
        gains: (n) one a joint.
        reference: The joint whose gain is the unit; None where a known mass gives N m per A.
        consistent: The arm and its loads as bodies that can exist, with those gains.
        equations: That they are from.
        fit: Of these.
    """

    gains: tuple[Gain, ...]
    reference: str | None
    consistent: ConsistentArm
    equations: CurrentEquations
    fit: GainFit

    @property
    def is_complete(self) -> bool:
        """Whether every joint's gain is told in N m per A."""
        return self.reference is None and all(gain.value is not None for gain in self.gains)

    @property
    def relative_rms(self) -> Float[ndarray, " joints"]:
        """Residual over current of each joint."""
        squares = np.mean(self.fit.residual**2, axis=0)
        return np.sqrt(squares / np.mean(self.equations.current**2, axis=0))


def estimate_gains(
    equations: CurrentEquations, stated: Float[ndarray, " joints"] | None = None
) -> Gains:
    """Estimate every joint's gain.

    Args:
        equations: Of currents without and with loads.
        stated: (n,) constants by which currents were multiplied before; ones if None.

    Raises:
        SolverFailed: If no consistent arm is found, which only rounding could do.
    """
    found = fit_gains(equations)
    consistent = consistent_arm(equations, found)
    place = equations.places["log_u"]
    covariance = found.covariance[place, place]
    log_k, least_squares = consistent.log_k, -found.x[place]
    factor = np.ones(equations.joints) if stated is None else stated
    reference = None if equations.has_scale else reference_joint(equations)
    if reference is not None:
        log_k = log_k - log_k[reference]
        least_squares = least_squares - least_squares[reference]
        factor = factor / factor[reference]
        to = np.eye(equations.joints)
        to[:, reference] -= 1.0
        covariance = to @ covariance @ to.T
    freedom = found.degrees_of_freedom[place]
    half = stats.t.ppf(0.5 + LEVEL / 2, freedom) * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    names = equations.model.arm.robot.joint_names
    felt = _felt(equations)
    gains = tuple(
        _gain(
            name,
            factor[j] * np.exp([log_k[j], least_squares[j] - half[j], least_squares[j] + half[j]]),
            half=float(half[j]),
            is_felt=bool(felt[j]),
        )
        for j, name in enumerate(names)
    )
    return Gains(
        gains, None if reference is None else names[reference], consistent, equations, found
    )


def _gain(name: str, told: Float[ndarray, "3"], *, half: float, is_felt: bool) -> Gain:
    """A gain from its value and its bounds.

    Args:
        name: Of the joint.
        told: Value, lower and upper bound.
        half: Half width of the interval of the logarithm.
        is_felt: Whether the joint feels a load in any posture or motion.
    """
    if half <= WIDEST:
        value, low, high = (float(x) for x in told)
        # Bodies that can exist may lie at the edge of what least squares allow.
        return Gain(name, value, (min(low, value), max(high, value)))
    width = "a factor of three or more" if half > 1 else f"{np.exp(half) - 1:.0%}"
    reason = (
        f"known to {width} only: the joint feels the load, and felt too little of it; move it faster, "
        "or in other postures"
        if is_felt
        else f"known to {width} only: no load at this place is felt by this joint, in no posture and no "
        "motion, and what it shares with other joints does not tell it"
    )
    return Gain(name, None, None, reason)


def _felt(equations: CurrentEquations) -> ndarray:
    """(n,) whether a joint feels any of the loads in any state."""
    robot = equations.model.arm.robot
    motion = random_motion(robot, STATES, np.random.default_rng(0))
    felt = np.zeros(robot.n, dtype=bool)
    for carrying in equations.loaded:
        columns = carrying.model.raw_columns(motion)[:, :, carrying.model.load]
        size = np.sqrt(np.mean(columns**2, axis=(0, 2)))
        felt |= size > FELT * size.max()
    return felt
