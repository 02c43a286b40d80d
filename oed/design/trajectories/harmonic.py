"""The paper's sums of sines with free amplitudes and frequencies (Calafiore 2001, eq. 10)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from math import comb

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.design.trajectories.ramp import Ramp
from oed.design.trajectories.term_moves import overtone, renew_term, split_term
from oed.design.trajectories.trajectory import Move, TrajectoryClass
from oed.robot import JointLimits

AMPLITUDE_BOUND = 4.0  # [rad or m] of each term, where sums may cancel under exact limits
# Highest frequency under exact limits, as a multiple of the conservative bound (12d). At four
# times it one sine within the acceleration limit moves a sixteenth of the position range.
FREQUENCY_MULTIPLE = 4.0
# Share of that box from which random motions take their frequencies.
DRAWN_FREQUENCIES = 0.4
# The D-optimal motion of one joint between position and acceleration limits is close to
# A (sin wt + sin(3 wt) / 54): the third harmonic flattens the acceleration.
THIRD_HARMONIC = 1 / 54
# Largest value of sin x + THIRD_HARMONIC sin 3x, at 90 degrees, and of sin x + 9 THIRD_HARMONIC
# sin 3x, at 60 degrees: what the third harmonic leaves of position and acceleration.
POSITION_CREST = 1 - THIRD_HARMONIC
ACCELERATION_CREST = np.sqrt(3) / 2


@dataclass(frozen=True)
class HarmonicClass(TrajectoryClass):
    """q_j(t) = centre_j + sum_k a_jk sin(omega_jk t), both a and omega free (10).

    z = [a_11 ... a_1W, a_21 ... a_nW, omega_11 ... omega_nW], the order of the paper's genotype.

    Attributes:
        horizon: [s]
        middle: (n,) fixed centre of each joint; zero in the paper.
        terms: W, the number of sines a joint.
        amplitude_bound: (n,) largest |a_jk| [rad or m].
        frequency_bound: (n,) largest omega_jk [rad/s].
        ramp: Seconds over which the motion rises from rest and returns to it; 0 for the
            paper's class, which starts at full speed.
        box_keeps_limits: Whether the box alone keeps the limits, by (11)-(12).
    """

    horizon: float
    middle: Float[ndarray, " joints"]
    terms: int
    amplitude_bound: Float[ndarray, " joints"]
    frequency_bound: Float[ndarray, " joints"]
    ramp: float = 0.0
    box_keeps_limits: bool = False
    name = "harmonic"
    is_linear = False
    has_offset = False

    def __post_init__(self) -> None:
        finite = np.isfinite(self.amplitude_bound) & np.isfinite(self.frequency_bound)
        if not finite.all():
            raise ValueError(f"joint {int(np.flatnonzero(~finite)[0]) + 1} has no finite box")

    @classmethod
    def conservative(cls, limits: JointLimits, horizon: float, terms: int = 3) -> HarmonicClass:
        """The class whose box keeps position, velocity and acceleration limits (12)."""
        middle, reach, omega = _conservative(limits)
        return cls(horizon, middle, terms, reach / terms, omega, box_keeps_limits=True)

    @classmethod
    def exact(
        cls,
        limits: JointLimits,
        horizon: float,
        terms: int = 3,
        *,
        amplitude_bound: float = AMPLITUDE_BOUND,
        frequency_multiple: float = FREQUENCY_MULTIPLE,
        ramp: float = 0.0,
    ) -> HarmonicClass:
        """The class with a wide box, to be used with limits on the motion itself."""
        middle, _, omega = _conservative(limits)
        wide = np.full(len(middle), amplitude_bound)
        return cls(horizon, middle, terms, wide, omega * frequency_multiple, ramp)

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.middle)

    @cached_property
    def bounds(self) -> Float[ndarray, "size 2"]:  # pyright: ignore[reportIncompatibleMethodOverride]  # a property too, and cached
        """|a| <= amplitude_bound and 0 <= omega <= frequency_bound."""
        amplitude = np.repeat(self.amplitude_bound, self.terms)
        frequency = np.repeat(self.frequency_bound, self.terms)
        lower = np.concatenate([-amplitude, np.zeros_like(frequency)])
        return np.stack([lower, np.concatenate([amplitude, frequency])], axis=1)

    @cached_property
    def variables(self) -> Int[ndarray, "joints own"]:  # pyright: ignore[reportIncompatibleMethodOverride]  # a property too, and cached
        """Amplitudes, then frequencies, of each joint."""
        amplitude = np.arange(self.joints * self.terms).reshape(self.joints, self.terms)
        return np.concatenate([amplitude, amplitude + amplitude.size], axis=1)

    def draw(self, rng: np.random.Generator) -> Float[ndarray, " size"]:
        """A random point; in a wide box frequencies are drawn from its slow part.

        A fast term would use up the acceleration and leave next to no motion. Slow ones of the
        full amplitude beat against one another, which is what a wide box is for.
        """
        if self.box_keeps_limits:
            return super().draw(rng)
        a = rng.uniform(-1, 1, (self.joints, self.terms)) * self.amplitude_bound[:, None]
        share = rng.uniform(0, DRAWN_FREQUENCIES, (self.joints, self.terms))
        omega = share * self.frequency_bound[:, None]
        return np.concatenate([a.reshape(-1), omega.reshape(-1)])

    def derivative(
        self, z: Float[ndarray, " size"], t: Float[ndarray, " samples"], order: int
    ) -> Float[ndarray, "samples joints"]:
        """Exact time derivative of position."""
        a, omega = self._parts(z)
        rest = self.middle if order == 0 else 0.0
        return rest + self._ramped(t, order, lambda t, k: (_wave(t, omega, k) * a).sum(axis=2))

    def sensitivity(
        self, z: Float[ndarray, " size"], t: Float[ndarray, " samples"], order: int
    ) -> Float[ndarray, "samples joints own"]:
        """By each joint's amplitudes, then frequencies."""
        a, omega = self._parts(z)

        def parts(t: ndarray, k: int) -> ndarray:
            by_amplitude = _wave(t, omega, k)
            # d/d omega of omega^k sin(omega t + k pi/2)
            by_omega = t[:, None, None] * _wave(t, omega, k, phase=1)
            if k > 0:
                by_omega = by_omega + k * _wave(t, omega, k - 1, phase=1)
            return np.concatenate([by_amplitude, a * by_omega], axis=2)

        return self._ramped(t, order, parts)

    def derivative_bound(self, z: Float[ndarray, " size"], order: int) -> Float[ndarray, " joints"]:
        """sum_k |a_k| omega_k^order, as in (11); with the ramp's own bounds by Leibniz."""
        a, omega = self._parts(z)
        bare = [(np.abs(a) * omega**k).sum(axis=1) for k in range(order + 1)]
        if not self.ramp:
            return bare[order]
        parts = (comb(order, k) * self._ramp.bound(order - k) * bare[k] for k in range(order + 1))
        return sum(parts, np.zeros(self.joints))

    def centre(
        self,
        z: Float[ndarray, " size"],  # noqa: ARG002  # the same for every z
    ) -> Float[ndarray, " joints"]:
        """The fixed middle."""
        return self.middle

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The ends of the ramp too."""
        inner = (self.ramp, self.horizon - self.ramp) if self.ramp else ()
        return (0.0, *inner, self.horizon)

    def shrink(
        self, z: Float[ndarray, " size"], factors: Float[ndarray, " joints"]
    ) -> Float[ndarray, " size"]:
        """Amplitudes multiplied, frequencies kept."""
        a, omega = self._parts(z)
        return np.concatenate([(a * factors[:, None]).reshape(-1), omega.reshape(-1)])

    def shift(
        self,
        z: Float[ndarray, " size"],
        distance: Float[ndarray, " joints"],  # noqa: ARG002  # the class has no offset
    ) -> Float[ndarray, " size"]:
        """Unchanged: the class has no offset."""
        return z

    def swing(
        self,
        middle: Float[ndarray, " joints"],  # noqa: ARG002  # the class has its own
        amplitude: Float[ndarray, " joints"],
        rate: Float[ndarray, " joints"],
    ) -> Float[ndarray, " size"] | None:
        """One sine a joint, with a little of its third harmonic where limits leave room for it."""
        if self.terms > 1 and not self.box_keeps_limits:
            amplitude = amplitude / POSITION_CREST
            rate = rate * np.sqrt(POSITION_CREST / ACCELERATION_CREST)
        a = np.zeros((self.joints, self.terms))
        omega = np.tile(rate[:, None], (1, self.terms))
        a[:, 0] = amplitude
        if self.terms > 1:
            a[:, 1] = amplitude * THIRD_HARMONIC
            omega[:, 1] = 3 * rate
        return np.concatenate([a.reshape(-1), omega.reshape(-1)])

    @property
    def moves(self) -> tuple[Move, ...]:
        """Of single terms, where there are several."""
        of_terms = (renew_term, split_term, overtone) if self.terms > 1 else ()
        return tuple(partial(move, self) for move in of_terms)  # pyright: ignore[reportArgumentType]  # a cached property is one

    def describe(self, z: Float[ndarray, " size"]) -> dict[str, ndarray]:
        """Centre, amplitudes and frequencies, (n, W) each."""
        a, omega = self._parts(z)
        return {
            "centre": self.middle,
            "amplitude": a,
            "frequency": omega,
            "ramp": np.array(self.ramp),
        }

    @classmethod
    def restore(
        cls,
        horizon: float,
        limits: JointLimits,
        coefficients: Mapping[str, ndarray],
    ) -> tuple[HarmonicClass, Float[ndarray, " size"]]:
        """The sums of these terms, in the least box that holds them."""
        names = ("centre", "amplitude", "frequency", "ramp")
        centre, a, omega, ramp = (coefficients.get(name, np.empty(0)) for name in names)
        shapes, joints = [x.shape for x in (centre, a, omega, ramp)], len(limits.position)
        terms = a.shape[1] if a.ndim == 2 else 0
        if shapes != [(joints,), (joints, terms), (joints, terms), ()] or not terms:
            raise ValueError(
                f"centre, amplitude, frequency and ramp have shapes {shapes}, not those of sums "
                f"of sines of {joints} joints"
            )
        box = (np.abs(a).max(axis=1), np.abs(omega).max(axis=1))
        restored = cls(horizon, centre, terms, *box, ramp=float(ramp))
        return restored, np.concatenate([a.reshape(-1), omega.reshape(-1)])

    def _parts(self, z: Float[ndarray, " size"]) -> tuple[ndarray, ndarray]:
        a, omega = np.asarray(z, dtype=float).reshape(2, self.joints, self.terms)
        return a, omega

    @cached_property
    def _ramp(self) -> Ramp:
        return Ramp(self.horizon, self.ramp)

    def _ramped(self, t: ndarray, order: int, part: Callable[[ndarray, int], ndarray]) -> ndarray:
        """Derivative of ramp times part, by Leibniz' rule; of part alone without a ramp."""
        if not self.ramp:
            return part(t, order)
        total = np.zeros(())
        for k in range(order + 1):
            values = part(t, k)
            factor = comb(order, k) * self._ramp.derivative(t, order - k)
            total = total + factor.reshape(-1, *(1,) * (values.ndim - 1)) * values
        return total


def _wave(t: ndarray, omega: ndarray, order: int, phase: int = 0) -> ndarray:
    """(N, n, W) omega^order sin(omega t + (order + phase) pi/2)."""
    times = np.ascontiguousarray(t, dtype=float).tobytes()
    waves = _sine_and_cosine(times, np.ascontiguousarray(omega).tobytes(), omega.shape)
    turned = (order + phase) % 4
    return ((1, 1, -1, -1)[turned] * omega**order) * waves[turned % 2]


@lru_cache(maxsize=4)
def _sine_and_cosine(t: bytes, omega: bytes, shape: tuple[int, int]) -> tuple[ndarray, ndarray]:
    """Of omega t: all derivatives and sensitivities at a point need the same two arrays."""
    angle = np.frombuffer(t)[:, None, None] * np.frombuffer(omega).reshape(shape)
    return np.sin(angle), np.cos(angle)


def _conservative(limits: JointLimits) -> tuple[ndarray, ndarray, ndarray]:
    """Middle and half width of the position range, and omega_max of (12d)."""
    if not np.isfinite(limits.position).all():
        raise ValueError("harmonic bounds (12) need finite position limits of every joint")
    middle = limits.position.mean(axis=1)
    reach = np.diff(limits.position, axis=1)[:, 0] / 2
    speed, acceleration = (np.abs(x).min(axis=1) for x in (limits.velocity, limits.acceleration))
    omega = np.minimum(speed / reach, np.sqrt(acceleration / reach))
    if not np.isfinite(omega).all():
        raise ValueError(
            "harmonic bounds (12) need a velocity or acceleration limit of every joint"
        )
    return middle, reach, omega
