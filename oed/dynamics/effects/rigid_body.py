"""Rigid-body dynamics: ten standard parameters a link, linear by (4)."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.newton_euler import inverse_dynamics, regressor_entries
from oed.dynamics.scalars import Scalar
from oed.robot import Robot

KEPT_BYTES = 64_000_000  # of entries along the motions that were asked for last


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
        """The Newton-Euler regressor; along sampled motions it is remembered."""
        if state.sampled is None:
            return regressor_entries(self.robot, state.q, state.dq, state.ddq)
        digest = blake2b(digest_size=16)
        for component in (*state.q, *state.dq, *state.ddq):
            digest.update(np.asarray(component, dtype=float).tobytes())
        key = digest.digest()
        if key not in self._memory:
            found = regressor_entries(self.robot, state.q, state.dq, state.ddq)
            self._memory[key] = len(state.sampled), found
        self._memory.move_to_end(key)
        _, found = self._memory[key]
        # Ten numbers for each link and each joint on the way to it, at most.
        most = KEPT_BYTES // (8 * 5 * self.robot.n * (self.robot.n + 1))
        while sum(samples for samples, _ in self._memory.values()) > most:
            self._memory.popitem(last=False)
        return found

    @cached_property
    def _memory(self) -> OrderedDict[bytes, tuple[int, list[dict[int, Scalar]]]]:
        return OrderedDict()

    def __getstate__(self) -> dict[str, object]:
        """What another process has to be told: nothing that it can work out."""
        return {"robot": self.robot}

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
