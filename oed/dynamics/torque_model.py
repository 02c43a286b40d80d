"""The torque model: rigid body plus effects, all of one shape."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects import (
    Coulomb,
    Effect,
    MeasurementEffect,
    Parameter,
    RigidBody,
    State,
    TorqueOffset,
    Viscous,
)
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import filled
from oed.robot import Robot

if TYPE_CHECKING:
    import casadi

OF_BODIES = (RigidBody, PayloadChange)  # whose parameters have the same units at every joint


@dataclass(frozen=True)
class TorqueModel:
    """Joint torque as a linear function of parameters (5), effect by effect.

    Attributes:
        robot: The machine.
        effects: What makes torque; usually `RigidBody` first.
        measurement: What the measurement does to the sum, innermost first.
    """

    robot: Robot
    effects: tuple[Effect, ...]
    measurement: tuple[MeasurementEffect, ...] = ()

    @classmethod
    def standard(
        cls, robot: Robot, *, offset: bool = False, sign_width: float = 0.0
    ) -> TorqueModel:
        """The paper's model: rigid body, Coulomb and viscous friction of every joint (15).

        Args:
            robot: The machine.
            offset: Whether to add a constant torque to every joint.
            sign_width: Width of the Coulomb terms' sign at revolute joints [rad/s]; at prismatic
                ones it is `Joint.speed` of that.
        """
        friction: list[Effect] = []
        for j, joint in enumerate(robot.joints):
            friction += [Coulomb(j, joint.speed(sign_width)), Viscous(j)]
        offsets = [TorqueOffset(j) for j in range(robot.n)] if offset else []
        return cls(robot, (RigidBody(robot), *friction, *offsets))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The p linear parameters, in column order; units are those of each joint's kind."""
        return tuple(
            p if isinstance(effect, OF_BODIES) or p.joint is None else self._at_joint(p, p.joint)
            for effect in self.effects
            for p in effect.parameters
        )

    def _at_joint(self, parameter: Parameter, joint: int) -> Parameter:
        """Such as a viscous friction in N s/m at a prismatic joint, which effects do not know."""
        unit = self.robot.joints[joint].unit(parameter.unit)
        return parameter if unit == parameter.unit else dataclasses.replace(parameter, unit=unit)

    @property
    def remembers(self) -> bool:
        """Whether the torque of an instant depends on those before it, or on the time."""
        return bool(self.measurement) or any(
            effect.keeps or effect.offline or effect.beyond_state for effect in self.effects
        )

    def with_effects(self, *effects: Effect) -> TorqueModel:
        """This model with more effects."""
        return dataclasses.replace(self, effects=(*self.effects, *effects))

    def with_measurement(self, *effects: MeasurementEffect) -> TorqueModel:
        """This model seen through further measurement effects."""
        return dataclasses.replace(self, measurement=(*self.measurement, *effects))

    def with_robot(self, robot: Robot) -> TorqueModel:
        """This model of another robot, such as the same one under another gravity."""
        effects = tuple(RigidBody(robot) if isinstance(e, RigidBody) else e for e in self.effects)
        return dataclasses.replace(self, robot=robot, effects=effects)

    @cached_property
    def rigid(self) -> Bool[ndarray, " parameters"]:
        """(p,) which parameters are the rigid body's."""
        own = [isinstance(effect, RigidBody) for effect in self.effects for _ in effect.parameters]
        return np.array(own, dtype=bool)

    def columns(self, motion: Motion) -> Float[ndarray, "samples joints parameters"]:
        """Torque per unit parameter at every instant and joint."""
        evaluate: Callable[[Motion], Float[ndarray, "samples joints parameters"]]
        evaluate = self._effect_columns
        for seen_through in self.measurement:
            evaluate = _compose(seen_through, evaluate, self.rigid)
        return evaluate(motion)

    def regressor(self, motion: Motion) -> Float[ndarray, "rows parameters"]:
        """H of (6a): row k n + j is joint j at instant k."""
        columns = self.columns(motion)
        return columns.reshape(-1, columns.shape[2])

    def torque(
        self, parameters: Float[ndarray, " parameters"], motion: Motion
    ) -> Float[ndarray, "samples joints"]:
        """Predicted torque of every joint [N m or N]."""
        return self.columns(motion) @ parameters

    def symbolic_columns(
        self, q: casadi.SX, dq: casadi.SX, ddq: casadi.SX, sign_width: float
    ) -> casadi.SX:
        """The (n, p) regressor at one instant as an expression.

        Args:
            q: (n, 1) position; likewise dq and ddq.
            dq: Velocity.
            ddq: Acceleration.
            sign_width: Smoothing of the velocity sign [rad/s], so that it has a derivative.
        """
        import casadi  # noqa: PLC0415  a quarter of a second that only expressions need

        state = State(0.0, *(casadi.vertsplit(x) for x in (q, dq, ddq)), sign_width=sign_width)
        result = casadi.SX(self.robot.n, len(self.parameters))
        for column, by_joint in enumerate(self._entries(state)):
            for joint, entry in by_joint.items():
                result[joint, column] = entry
        return result

    def _effect_columns(self, motion: Motion) -> Float[ndarray, "samples joints parameters"]:
        return filled(self._entries(State.along(motion)), len(motion), self.robot.n)

    def _entries(self, state: State) -> list:
        return [entry for effect in self.effects for entry in effect.entries(state)]


def _compose(
    effect: MeasurementEffect,
    inner: Callable[[Motion], Float[ndarray, "samples joints parameters"]],
    rigid: Bool[ndarray, " parameters"],
) -> Callable[[Motion], Float[ndarray, "samples joints parameters"]]:
    return lambda motion: effect.through(inner, motion, rigid)
