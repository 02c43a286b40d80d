"""Acceleration of an arm whose torque is known: its model solved for ddq at one instant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.array_function import array_function
from oed.dynamics.effects import State
from oed.dynamics.effects.measurement_effect import Instants
from oed.errors import OedError

# Torque is linear in the acceleration but for friction under load, which has corners: a step of
# Newton's is exact on each side of one.
MOST_STEPS = 30
EXACT = 1e-12  # of the largest torque


class NoAcceleration(OedError):
    """No acceleration makes the torque that is applied, as of a body without inertia."""


@dataclass(frozen=True)
class ForwardDynamics:
    """Solves tau(q, dq, ddq, memory) = applied.

    Attributes:
        torque: (q, dq, ddq, memory) -> torque, memory at the next instant, derivative by ddq.
        begin: (q, dq, ddq) -> memory at the first instant.
    """

    torque: casadi.Function
    begin: casadi.Function

    @classmethod
    def of(cls, instants: Instants, joints: int, *, sign_width: float = 0.0) -> ForwardDynamics:
        """Of a torque that is worked out one instant after another.

        Args:
            instants: That torque.
            joints: Number of joints.
            sign_width: Velocity over which every sign turns at least [rad/s].
        """
        q, dq, ddq = (casadi.SX.sym(name, joints) for name in ("q", "dq", "ddq"))
        memory = casadi.SX.sym("memory", len(instants.keeps))
        state = State(0.0, *(casadi.vertsplit(x) for x in (q, dq, ddq)), sign_width=sign_width)
        kept = casadi.vertsplit(memory) if instants.keeps else []
        torque, following = (
            casadi.vertcat(casadi.SX(0, 1), *x) for x in instants.recall(state, kept)
        )
        begun = casadi.vertcat(casadi.SX(0, 1), *instants.begin(state))
        outputs = [torque, following, casadi.jacobian(torque, ddq)]
        return cls(
            casadi.Function("torque", [q, dq, ddq, memory], outputs, {"cse": True}),
            casadi.Function("begin", [q, dq, ddq], [begun]),
        )

    @cached_property
    def array_torque(self) -> Callable[..., list[ndarray]]:
        """`torque` on arrays."""
        return array_function(self.torque)

    def acceleration(
        self,
        q: Float[ndarray, " joints"],
        dq: Float[ndarray, " joints"],
        memory: Float[ndarray, " kept"],
        applied: Float[ndarray, " joints"],
        *,
        start: Float[ndarray, " joints"] | None = None,
    ) -> tuple[Float[ndarray, " joints"], Float[ndarray, " kept"]]:
        """The acceleration, and what is remembered at the next instant.

        Args:
            q: Position [rad or m].
            dq: Velocity.
            memory: At that instant.
            applied: Torque [N m or N].
            start: Where the search begins; at zero if None.

        Raises:
            NoAcceleration: If none is found.
        """
        ddq = np.zeros(len(q)) if start is None else np.array(start)
        for _ in range(MOST_STEPS):
            torque, following, slope = self.array_torque(q, dq, ddq, memory)
            missing = applied - torque.ravel()
            size = np.abs(applied).max() + np.abs(torque).max()
            if np.abs(missing).max() <= EXACT * max(size, 1.0):
                return ddq, following.ravel()
            try:
                ddq = ddq + np.linalg.solve(slope, missing)
            except np.linalg.LinAlgError as error:
                raise NoAcceleration(f"the mass matrix is singular at q = {q}") from error
        raise NoAcceleration(f"no acceleration makes the torque {applied} at q = {q}")
