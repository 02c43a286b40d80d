"""What the laboratory's instruments make of position and torque."""

from __future__ import annotations

from dataclasses import dataclass

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.disturbance import Disturbance


@dataclass(frozen=True)
class Sensors:
    """Encoder or resolver, torque signal and logger.

    Attributes:
        resolution: (n,) least step of the position reading [rad]; empty for exact positions.
        torque_noise: Noise on the logged torque alone, which the arm does not feel.
        torque_delay: (n,) by how much the logged torque is late [s]; empty for none.
        logs_velocity: Whether the observer's velocity is logged as `dq`.
    """

    resolution: tuple[float, ...] = ()
    torque_noise: Disturbance | None = None
    torque_delay: tuple[float, ...] = ()
    logs_velocity: bool = False

    @classmethod
    def resolvers(cls, joints: int, bits: int, *, logs_velocity: bool = True) -> Sensors:
        """Resolver-to-digital converters of so many bits a turn on every joint."""
        return cls((2 * np.pi / 2**bits,) * joints, logs_velocity=logs_velocity)

    def encode(self, q: casadi.SX) -> casadi.SX:
        """Position as read, rounded down to the step plus half of it."""
        if not self.resolution:
            return q
        step = casadi.DM(self.resolution)
        return (casadi.floor(q / step) + 0.5) * step

    def torque(
        self,
        command: Float[ndarray, "samples joints runs"],
        period: float,
        rng: np.random.Generator,
    ) -> Float[ndarray, "samples joints runs"]:
        """Torque as logged."""
        logged = command
        if any(self.torque_delay):
            t = np.arange(len(command)) * period
            logged = np.empty_like(command)
            for j, delay in enumerate(self.torque_delay):
                for r in range(command.shape[2]):
                    logged[:, j, r] = np.interp(t - delay, t, command[:, j, r])
        if self.torque_noise is None:
            return logged
        return logged + self.torque_noise.sample(len(command), command.shape[2], period, rng)
