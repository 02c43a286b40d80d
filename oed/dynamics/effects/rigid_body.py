"""Rigid-body dynamics: ten standard parameters a link, linear by (4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.newton_euler import inverse_dynamics, regressor_entries
from oed.dynamics.scalars import Scalar
from oed.robot import Robot


@dataclass(frozen=True)
class RigidBody(Effect):
    """Inertia, Coriolis and gravity torque of a robot (Calafiore 2001, eq. 4)."""

    robot: Robot
    name = "rigid_body"
    part = "body"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The standard parameters of every link, in the robot's order."""
        robot = self.robot
        return tuple(
            Parameter(name, unit, c // 10)
            for c, (name, unit) in enumerate(
                zip(robot.parameter_names, robot.parameter_units, strict=True)
            )
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """All joint coordinates."""
        return tuple(f"{x}_{i + 1}" for x in ("q", "dq", "ddq") for i in range(self.robot.n))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The Newton-Euler regressor."""
        return regressor_entries(self.robot, state.q, state.dq, state.ddq)

    def recall_torque(
        self,
        state: State,
        memory: Sequence[Scalar],  # noqa: ARG002  # a body keeps nothing
        step: float,  # noqa: ARG002
        coefficients: Float[ndarray, " columns"],
    ) -> tuple[Mapping[int, Scalar], Sequence[Scalar]]:
        """By the recursion, which takes a tenth of the regressor's operations."""
        known = self.robot.with_parameters(coefficients)
        return dict(enumerate(inverse_dynamics(known, state.q, state.dq, state.ddq))), ()
