"""Torque of what a simulator's own joints and bodies lack, one step after another."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import with_columns
from oed.dynamics.effects.effect import JointTerm
from oed.dynamics.forward import ForwardDynamics
from oed.dynamics.online import Offline, of_the_arm
from oed.export.model import Model

# Signs turn over this velocity at least: steps of a millisecond can follow it.
SIGN_WIDTH = 0.02  # [rad/s or m/s]


@dataclass(frozen=True)
class EffectTorque:
    """What the arm needs beside its bodies and what the simulator has of its joints.

    Attributes:
        dynamics: Of that torque alone.
        follows_acceleration: Whether it depends on the acceleration, as friction under load does.
        keeps: Names of what it remembers from one step to the next.
    """

    dynamics: ForwardDynamics
    follows_acceleration: bool
    keeps: tuple[str, ...]

    @classmethod
    def of(
        cls,
        model: Model,
        native: Collection[JointTerm],
        step: float,
        *,
        sign_width: float = SIGN_WIDTH,
    ) -> EffectTorque:
        """Of a model in a simulator.

        Args:
            model: Its measurement effects are no part of the arm.
            native: What the simulator has of its joints.
            step: Of the simulation [s].
            sign_width: Velocity over which signs turn at least [rad/s]; 0 for the model's own.
        """
        whole = model.torque_model
        chosen = [
            (effect, model.parameters[place])
            for effect, place in list(with_columns(whole.effects))[1:]
            if effect.joint_term not in native and not effect.offline
        ]
        sizes = np.concatenate([np.zeros(0), *(own for _, own in chosen)])
        instants = of_the_arm([e for e, _ in chosen], sizes, whole.robot.n, step)
        dynamics = ForwardDynamics.of(instants, whole.robot.n, sign_width=sign_width)
        follows = dynamics.torque.sparsity_out(2).nnz() > 0
        return cls(dynamics, follows, instants.keeps)

    def begin(
        self, q: Float[ndarray, " joints"], dq: Float[ndarray, " joints"]
    ) -> Float[ndarray, " kept"]:
        """What is remembered at the first instant of a simulation."""
        return np.array(self.dynamics.begin(q, dq, np.zeros_like(q))).ravel()

    def torque(
        self,
        q: Float[ndarray, " joints"],
        dq: Float[ndarray, " joints"],
        ddq: Float[ndarray, " joints"],
        memory: Float[ndarray, " kept"],
    ) -> tuple[Float[ndarray, " joints"], Float[ndarray, " kept"]]:
        """The torque at one instant [N m or N], and what is remembered at the next."""
        torque, following, _ = self.dynamics.array_torque(q, dq, ddq, memory)
        return torque.ravel(), following.ravel()


def not_simulated(model: Model) -> tuple[Offline, ...]:
    """What of a model can act in no simulation of the arm, and why."""
    effects = (Offline(e.name, e.offline) for e in model.torque_model.effects if e.offline)
    measured = (Offline(m.name, m.not_simulated) for m in model.torque_model.measurement)
    return (*effects, *measured)


def whole_arm(model: Model, step: float, *, sign_width: float = SIGN_WIDTH) -> ForwardDynamics:
    """Forward dynamics of the arm with all that can act in a simulation; arguments as above."""
    whole = model.torque_model
    kept = [(e, model.parameters[p]) for e, p in with_columns(whole.effects) if not e.offline]
    sizes = np.concatenate([own for _, own in kept])
    instants = of_the_arm([e for e, _ in kept], sizes, whole.robot.n, step)
    return ForwardDynamics.of(instants, whole.robot.n, sign_width=sign_width)
