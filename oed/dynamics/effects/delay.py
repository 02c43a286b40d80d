"""Torque that is recorded late: a pure delay, or the lag of a filter."""

from __future__ import annotations

import dataclasses
import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Complex, Float
from numpy import ndarray
from scipy.interpolate import make_interp_spline
from scipy.ndimage import spline_filter1d
from scipy.signal import lfilter_zi

from oed.dynamics.effects.effect import State
from oed.dynamics.effects.linear_filter import discrete, is_even, respond
from oed.dynamics.effects.measurement_effect import Instants, MeasurementEffect
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import Scalar, add, mul, sub

HELD = (
    24  # samples beyond an end, by which a cubic spline has forgotten it: 0.27 ** 24 of it is left
)
LEAST = 4  # samples of a cubic
WHOLE = 1e-9  # of a step: a delay that near to whole steps has no rest


class Late(MeasurementEffect):
    """Torque that is recorded late, through a linear filter that does not change with time."""

    @property
    @abstractmethod
    def lag(self) -> float:
        """By how much slow torques are late [s]."""

    def undone(
        self, t: Float[ndarray, " samples"], tau: Float[ndarray, "samples joints"]
    ) -> Float[ndarray, "samples joints"]:
        """The torque moved to when it acted, held at the ends; a filter's damping stays."""
        return np.stack([np.interp(t + self.lag, t, own) for own in tau.T], axis=1)

    @abstractmethod
    def response(
        self, frequency: Float[ndarray, " frequencies"]
    ) -> Complex[ndarray, " frequencies"]:
        """Gain and phase of the filter at some frequencies [Hz]."""


@dataclass(frozen=True)
class TimeDelay(Late):
    """Recorded torque at t is the model's torque at t - delay.

    Where samples are means over a step the torque is moved, for in them a change of sign lies where
    it was. Samples of an instant put it at one of them: there the motion is moved, so that it stays
    sharp. Before the first sample the arm is taken to stand in the first sample's state.

    Attributes:
        delay: [s]; negative if the position is the late one.
    """

    delay: float
    name = "time_delay"

    @property
    def lag(self) -> float:
        """The delay."""
        return self.delay

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
        rigid: Bool[ndarray, " columns"],  # noqa: ARG002  # all columns alike
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns as they were earlier."""
        if motion.averaged:
            return _moved(motion.t, columns(motion), self.delay)
        return columns(motion.changed(self, lambda: delayed(motion, self.delay)))

    @property
    def offline(self) -> str:
        """A torque that comes before its motion."""
        if self.delay >= 0:
            return ""
        return "the torque is recorded before the motion that it makes, which nobody knows by then"

    def after(self, inner: Instants, joints: int, step: float) -> Instants:
        """The torque of the state as it was.

        Between instants position and velocity are cubic with the slopes that they have, and
        acceleration is straight.
        """
        if self.offline:
            raise ValueError(f"{self.name}: {self.offline}")
        steps = self.delay / step
        whole = round(steps) if abs(steps - round(steps)) < WHOLE else int(steps)
        share = max(steps - whole, 0.0) if abs(steps - round(steps)) >= WHOLE else 0.0
        count, width = whole + (share > 0), 3 * joints

        def begin(state: State) -> list[Scalar]:
            return [*(x for _ in range(count) for x in _flat(state)), *inner.begin(state)]

        def recall(state: State, memory: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
            past = [list(memory[k * width : (k + 1) * width]) for k in range(count)]
            instants = [_flat(state), *past]
            then = instants[whole]
            if share > 0:
                then = _between(instants[whole + 1], then, 1 - share, step)
            q, dq, ddq = (then[k * joints : (k + 1) * joints] for k in range(3))
            torque, kept = inner.recall(State(state.t, q, dq, ddq), memory[count * width :])
            recent = [x for instant in instants[:count] for x in instant]
            return torque, [*recent, *kept]

        signals = [f"{x}_{j + 1}" for x in ("q", "dq", "ddq") for j in range(joints)]
        names = tuple(f"{x} {k + 1} steps ago" for k in range(count) for x in signals)
        return Instants(names, begin, recall)

    def response(
        self, frequency: Float[ndarray, " frequencies"]
    ) -> Complex[ndarray, " frequencies"]:
        """exp(-s delay)."""
        return np.exp(-2j * np.pi * frequency * self.delay)


@dataclass(frozen=True)
class FilterLag(Late):
    """Recorded torque is the model's torque through 1 / (1 + T s + kappa T^2 s^2).

    kappa = 0 is the first-order lag, 1/4 two equal ones, 1/2 a Butterworth filter; all have
    the same delay T at low frequency.

    Attributes:
        time_constant: T [s].
        curvature: kappa.
    """

    time_constant: float
    curvature: float = 0.0
    name = "filter_lag"

    @property
    def lag(self) -> float:
        """The time constant."""
        return self.time_constant

    def __post_init__(self) -> None:
        if self.time_constant <= 0 or self.curvature < 0:
            raise ValueError(
                f"{self.time_constant=} must be positive and {self.curvature=} at least 0"
            )

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
        rigid: Bool[ndarray, " columns"],  # noqa: ARG002  # all columns alike
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns through the filter."""
        return respond(motion.t, columns(motion), *self._transfer)

    def after(self, inner: Instants, joints: int, step: float) -> Instants:
        """The torque through the filter, settled at the first instant."""
        b, a = discrete(step, *self._transfer)
        settled = lfilter_zi(b, a).tolist()
        order = len(settled)

        def begin(state: State) -> list[Scalar]:
            own = inner.begin(state)
            torque, _ = inner.recall(state, own)
            return [*(mul(z, x) for x in torque for z in settled), *own]

        def recall(state: State, memory: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
            torque, kept = inner.recall(state, memory[order * joints :])
            seen, following = [], []
            for j, x in enumerate(torque):
                z = [*memory[j * order : (j + 1) * order], 0.0]
                y = add(mul(float(b[0]), x), z[0])
                seen.append(y)
                following += [
                    add(sub(mul(float(b[k]), x), mul(float(a[k]), y)), z[k])
                    for k in range(1, order + 1)
                ]
            return seen, [*following, *kept]

        names = (f"filter {k + 1} of tau_{j + 1}" for j in range(joints) for k in range(order))
        return Instants(tuple(names), begin, recall)

    @property
    def _transfer(self) -> tuple[list[float], list[float]]:
        """Numerator and denominator."""
        T = self.time_constant
        second_order = [self.curvature * T**2] if self.curvature > 0 else []
        return [1.0], [*second_order, T, 1.0]

    def response(
        self, frequency: Float[ndarray, " frequencies"]
    ) -> Complex[ndarray, " frequencies"]:
        """1 / (1 + T s + kappa T^2 s^2)."""
        delayed_by = 2j * np.pi * frequency * self.time_constant
        return 1 / (1 + delayed_by + self.curvature * delayed_by**2)


def delayed(motion: Motion, delay: float) -> Motion:
    """The motion as it was `delay` seconds earlier, at the same instants.

    Args:
        motion: Smooth between samples: cubic in position and velocity.
        delay: [s].
    """
    instants = earlier(motion, delay)
    q, dq, ddq = (curve(instants) for curve in motion.curves)
    return dataclasses.replace(motion, q=q, dq=dq, ddq=ddq)


def _moved(
    t: Float[ndarray, " samples"], u: Float[ndarray, "samples joints columns"], delay: float
) -> Float[ndarray, "samples joints columns"]:
    """Columns as they were some seconds earlier, by a cubic spline; at both ends they are held.

    On even samples the spline is a recursive filter, and its value between two samples the same
    four-term sum everywhere (Unser, Aldroubi, Eden 1993, IEEE Trans. Signal Processing 41(2)).
    """
    steps = (len(t) - 1) * delay / float(t[-1] - t[0])
    if len(t) < LEAST or not is_even(t):
        return make_interp_spline(t, u, k=3)(np.clip(t - delay, t[0], t[-1]))
    whole = math.floor(-steps)
    held = min(abs(whole), len(t)) + HELD
    padded = np.pad(u, ((held, held), (0, 0), (0, 0)), mode="edge")
    spline = spline_filter1d(padded, order=3, axis=0, mode="mirror")
    x = -steps - whole
    weights = ((1 - x) ** 3, 4 - 6 * x**2 + 3 * x**3, 4 - 6 * (1 - x) ** 2 + 3 * (1 - x) ** 3, x**3)
    first = held + max(min(whole, len(t)), -len(t)) - 1
    moved = np.zeros_like(u)
    for k, weight in enumerate(weights):
        moved += weight / 6 * spline[first + k : first + k + len(t)]
    return moved


def earlier(motion: Motion, delay: float) -> Float[ndarray, " samples"]:
    """Instants of a motion some seconds before each of its samples, none outside of it [s]."""
    return np.clip(motion.t - delay, motion.t[0], motion.t[-1])


def _flat(state: State) -> list[Scalar]:
    return [*state.q, *state.dq, *state.ddq]


def _between(
    old: Sequence[Scalar], new: Sequence[Scalar], share: float, step: float
) -> list[Scalar]:
    """q, dq and ddq between two instants, at a share of the way from the old one."""
    joints = len(old) // 3
    s = share
    ends = ((1 + 2 * s) * (1 - s) ** 2, s**2 * (3 - 2 * s))
    slopes = (step * s * (1 - s) ** 2, step * s**2 * (s - 1))
    found = [
        add(
            add(mul(ends[0], old[k]), mul(ends[1], new[k])),
            add(mul(slopes[0], old[k + joints]), mul(slopes[1], new[k + joints])),
        )
        for k in range(2 * joints)
    ]
    line = range(2 * joints, 3 * joints)
    return [*found, *(add(mul(1 - s, old[k]), mul(s, new[k])) for k in line)]
