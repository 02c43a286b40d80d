"""Independent joint feedback with a high-gain observer (Calafiore 2001, 17c), and its gains."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float
from numpy import ndarray
from scipy.linalg import expm
from scipy.optimize import brentq

from oed.errors import OedError
from oed.experiment.observer import HighGainObserver

GRID_POINTS = 600  # two decades below the bandwidth to well above it, a percent apart
DAMPING_TOLERANCE = 1e-4  # of the damping ratio
PEAK_TOLERANCE = 0.01  # [dB] kept in hand for the grid


class SpecificationUnmet(OedError):
    """No gains meet the specification.

    Attributes:
        peak_db: Least peak found [dB].
    """

    def __init__(self, message: str, peak_db: float) -> None:
        super().__init__(message)
        self.peak_db = peak_db


@dataclass(frozen=True)
class Controller:
    """tau = K_p (q_d - q) + K_d (dq_d - x_2), sampled, x_2 from the observer.

    Attributes:
        stiffness: (n,) diagonal of K_p [N m/rad].
        damping: (n,) diagonal of K_d [N m s/rad].
        observer: Of velocity.
        period: Sampling period T [s].
    """

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    observer: HighGainObserver
    period: float = 0.001

    def __post_init__(self) -> None:
        if not len(self.stiffness) == len(self.damping) == self.observer.n:
            raise ValueError(
                f"{len(self.stiffness)} stiffnesses, {len(self.damping)} dampings, "
                f"observer of {self.observer.n} joints"
            )
        if min(*self.stiffness, *self.damping, self.period) <= 0:
            raise ValueError("K_p, K_d and the period must be positive")

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.stiffness)


@dataclass(frozen=True)
class JointLoad:
    """What a joint's loop sees of the arm: inertia and viscous friction alone.

    Attributes:
        inertia: Typical inertia, for the bandwidth [kg m^2].
        extremes: Least and greatest inertia over the workspace, for the peak [kg m^2].
        viscous: [N m s/rad].
    """

    inertia: float
    extremes: tuple[float, float]
    viscous: float


@dataclass(frozen=True)
class Specification:
    """What the closed loop from q_d to q must do (Calafiore 2001, section 4).

    Attributes:
        bandwidth: Frequency where the gain has fallen to -3 dB, at typical inertia [rad/s].
        peak_db: Most that the gain may exceed 1, at any inertia [dB].
    """

    bandwidth: float = 60.0
    peak_db: float = 4.0


def closed_loop_response(  # noqa: PLR0917  # the loop's elements, in order
    frequency: Float[ndarray, " points"],
    inertia: float,
    viscous: float,
    stiffness: float,
    damping: float,
    observer: HighGainObserver,
    joint: int,
    period: float,
) -> Complex[ndarray, " points"]:
    """Frequency response from q_d to q at the sampling instants, observer and hold included.

    Args:
        frequency: [rad/s], below pi / period.
        inertia: [kg m^2].
        viscous: [N m s/rad].
        stiffness: K_p of the joint.
        damping: K_d of the joint.
        observer: Whose joint `joint` is meant.
        joint: Index.
        period: Sampling period [s].
    """
    z = np.exp(1j * frequency * period)
    arm = _transfer(*_held(inertia, viscous, period), np.array([1.0, 0.0]), z)
    A, B, D = observer.discretised(period)
    velocity = _transfer(A[joint], B[joint], np.array([0.0, 1.0]), z) + D[joint, 1]
    feedback = stiffness + damping * velocity
    return arm * (stiffness + damping * 1j * frequency) / (1 + arm * feedback)


def closed_loop_poles(  # noqa: PLR0917  # as closed_loop_response
    inertia: float,
    viscous: float,
    stiffness: float,
    damping: float,
    observer: HighGainObserver,
    joint: int,
    period: float,
) -> Complex[ndarray, "4"]:
    """Eigenvalues of the sampled loop of arm and observer; inside the unit circle if stable."""
    arm, push = _held(inertia, viscous, period)
    A, B, D = observer.discretised(period)
    feedback = np.array([-stiffness - damping * D[joint, 1], 0.0, 0.0, -damping])
    loop = np.zeros((4, 4))
    loop[:2, :2] = arm
    loop[:2] += np.outer(push, feedback)
    loop[2:, 2:] = A[joint]
    loop[2:, 0] = B[joint]
    return np.linalg.eigvals(loop).astype(complex)


def bandwidth_and_peak(
    frequency: Float[ndarray, " points"], response: Complex[ndarray, " points"]
) -> tuple[float, float]:
    """First frequency where the gain falls through -3 dB [rad/s], and the peak gain [dB]."""
    gain = 20 * np.log10(np.abs(response))
    half_power = gain[0] - 10 * np.log10(2.0)
    below = np.flatnonzero(gain < half_power)
    if not below.size:
        return float("inf"), float(gain.max() - gain[0])
    pair = [below[0], below[0] - 1]  # falling gain: the later point first
    bandwidth = np.exp(np.interp(half_power, gain[pair], np.log(frequency[pair])))
    return float(bandwidth), float(gain.max() - gain[0])


def design_gains(
    loads: tuple[JointLoad, ...],
    observer: HighGainObserver,
    specification: Specification,
    period: float = 0.001,
) -> Controller:
    """The stiffest gains that meet the specification, joint by joint.

    For a damping ratio zeta, K_p = M w^2 and K_d = 2 zeta M w - F_v, with w such that the
    bandwidth at typical inertia is the specified one. More damping lowers the peak, and
    lowers w: the least zeta whose peak is allowed at every inertia gives the most stiffness.

    Raises:
        SpecificationUnmet: If no damping ratio up to 2 keeps the peak.
    """
    gains = [
        _joint_gains(load, observer, joint, specification, period)
        for joint, load in enumerate(loads)
    ]
    stiffness, damping = zip(*gains, strict=True)
    return Controller(stiffness, damping, observer, period)


def _joint_gains(
    load: JointLoad,
    observer: HighGainObserver,
    joint: int,
    specification: Specification,
    period: float,
) -> tuple[float, float]:
    target = specification.bandwidth
    grid = np.geomspace(target / 100, min(20 * target, 0.95 * np.pi / period), GRID_POINTS)

    def response(inertia: float, zeta: float, w: float) -> Complex[ndarray, " points"]:
        stiffness = load.inertia * w**2
        damping = max(2 * zeta * load.inertia * w - load.viscous, 1e-9)
        return closed_loop_response(
            grid, inertia, load.viscous, stiffness, damping, observer, joint, period
        )

    def tuned(zeta: float) -> float:
        def excess(w: float) -> float:
            found, _ = bandwidth_and_peak(grid, response(load.inertia, zeta, w))
            return np.log(min(found, grid[-1]) / target)

        return float(brentq(excess, target / 20, 2 * target, xtol=1e-5))  # pyright: ignore[reportArgumentType]

    def margin(zeta: float) -> float:
        w = tuned(zeta)
        peaks = [bandwidth_and_peak(grid, response(m, zeta, w))[1] for m in load.extremes]
        return max(peaks) - specification.peak_db + PEAK_TOLERANCE

    low, high = 0.1, 2.0
    if margin(high) > 0:
        raise SpecificationUnmet(
            f"joint {joint + 1}: the peak is at least {margin(high) + specification.peak_db:.2f} dB "
            f"at bandwidth {specification.bandwidth:g} rad/s",
            margin(high) + specification.peak_db,
        )
    zeta = _least(margin, low, high)
    w = tuned(zeta)
    return load.inertia * w**2, 2 * zeta * load.inertia * w - load.viscous


def _least(margin: Callable[[float], float], low: float, high: float) -> float:
    """Least argument at which a falling function is not positive."""
    if margin(low) <= 0:
        return low
    while high - low > DAMPING_TOLERANCE:
        middle = (low + high) / 2
        low, high = (middle, high) if margin(middle) > 0 else (low, middle)
    return high


def _held(
    inertia: float, viscous: float, period: float
) -> tuple[Float[ndarray, "2 2"], Float[ndarray, "2"]]:
    """A and B of position and velocity over one period under a held torque."""
    block = np.array([[0.0, 1.0, 0.0], [0.0, -viscous / inertia, 1 / inertia], [0.0, 0.0, 0.0]])
    step = expm(block * period)
    return step[:2, :2], step[:2, 2]


def _transfer(
    A: Float[ndarray, "2 2"],
    B: Float[ndarray, "2"],
    C: Float[ndarray, "2"],
    z: Complex[ndarray, " points"],
) -> Complex[ndarray, " points"]:
    """C (z I - A)^-1 B of a two-state system."""
    determinant = (z - A[0, 0]) * (z - A[1, 1]) - A[0, 1] * A[1, 0]
    first = (z - A[1, 1]) * B[0] + A[0, 1] * B[1]
    second = A[1, 0] * B[0] + (z - A[0, 0]) * B[1]
    return (C[0] * first + C[1] * second) / determinant
