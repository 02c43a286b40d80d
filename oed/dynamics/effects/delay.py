"""Torque that is recorded late: a pure delay, or the lag of a filter."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float
from numpy import ndarray
from scipy.interpolate import make_interp_spline

from oed.dynamics.effects.effect import MeasurementEffect
from oed.dynamics.effects.linear_filter import respond
from oed.dynamics.motion import Motion


class Late(MeasurementEffect):
    """Torque that is recorded late, through a linear filter that does not change with time."""

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

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns as they were earlier."""
        if motion.averaged:
            return self.moved(make_interp_spline(motion.t, columns(motion), k=3), motion)
        return columns(delayed(motion, self.delay))

    def moved(
        self, torque: Callable[[Float[ndarray, " samples"]], ndarray], motion: Motion
    ) -> ndarray:
        """A torque along a motion, known between its samples too, as it is recorded at these.

        Args:
            torque: Of means over a step, by time [N m].
            motion: Gives the instants.
        """
        return torque(earlier(motion, self.delay))

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

    def __post_init__(self) -> None:
        if self.time_constant <= 0 or self.curvature < 0:
            raise ValueError(
                f"{self.time_constant=} must be positive and {self.curvature=} at least 0"
            )

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns through the filter."""
        T = self.time_constant
        second_order = [self.curvature * T**2] if self.curvature > 0 else []
        return respond(motion.t, columns(motion), [1.0], [*second_order, T, 1.0])

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


def earlier(motion: Motion, delay: float) -> Float[ndarray, " samples"]:
    """Instants of a motion some seconds before each of its samples, none outside of it [s]."""
    return np.clip(motion.t - delay, motion.t[0], motion.t[-1])
