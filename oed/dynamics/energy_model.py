"""The energy form of a torque model: work over windows instead of torque at instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.integrate import cumulative_simpson

from oed.dynamics.effects import Effect, Parameter, RigidBody
from oed.dynamics.energy import energy_regressor
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel


@dataclass(frozen=True)
class EnergyModel:
    """Work of the joint torques between instants, linear in the torque model's parameters.

    Over each window of `window` samples, integral of dq' tau dt = [h(end) - h(start)] pi +
    sum over effects of integral of dq' columns dt. Same parameters and column order as the
    torque model; one row a window; accelerations are not used by the rigid body.

    Attributes:
        model: Has no measurement effect: they act on torques, not on work.
        window: Samples a row.
    """

    model: TorqueModel
    window: int

    def __post_init__(self) -> None:
        if self.window < 1:
            raise ValueError(f"{self.window=} must hold at least one sample")
        if self.model.measurement:
            names = [effect.name for effect in self.model.measurement]
            raise ValueError(f"no energy form of a model seen through {names}")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The torque model's parameters."""
        return self.model.parameters

    def regressor(self, motion: Motion) -> Float[ndarray, "rows parameters"]:
        """Work per unit of each parameter over each window [J per unit]."""
        parts = [self._energy(effect, motion) for effect in self.model.effects]
        return np.diff(np.concatenate(parts, axis=1)[self._edges(motion)], axis=0)

    def target(
        self, motion: Motion, torque: Float[ndarray, "samples joints"]
    ) -> Float[ndarray, " rows"]:
        """Work of measured torques over each window [J]."""
        power = np.einsum("kj,kj->k", motion.dq, torque)
        return np.diff(_integral(power[:, None], motion.t)[self._edges(motion), 0])

    def _edges(self, motion: Motion) -> ndarray:
        return np.arange(0, len(motion), self.window)

    def _energy(self, effect: Effect, motion: Motion) -> Float[ndarray, "samples columns"]:
        if isinstance(effect, RigidBody):
            return energy_regressor(effect.robot, motion)
        columns = TorqueModel(self.model.robot, (effect,)).columns(motion)
        return _integral(np.einsum("kj,kjc->kc", motion.dq, columns), motion.t)


def _integral(
    power: Float[ndarray, "samples columns"], t: Float[ndarray, " samples"]
) -> Float[ndarray, "samples columns"]:
    return cumulative_simpson(power, x=t, axis=0, initial=0.0)
