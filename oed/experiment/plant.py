"""The machine as it really is, for simulation: rigid body, effects, memory and secrets."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Effect, State
from oed.dynamics.newton_euler import inverse_dynamics
from oed.dynamics.scalars import Scalar, add, mul
from oed.experiment.friction_memory import MemoryTorque
from oed.robot import Robot

# torque(state, rigid_body_torque) -> extra torque by joint, in CasADi scalars
ExtraTorque = Callable[[State, Sequence[Scalar]], Mapping[int, Scalar]]
# A torque that depends on the load makes the acceleration implicit; friction on load is a
# contraction by some tenths, so this many Newton steps reach rounding.
NEWTON_STEPS = 3


@dataclass(frozen=True)
class TruePlant:
    """A simulated arm. Every torque counts as needed by the arm, as in the torque model.

    Attributes:
        robot: With the true inertial parameters and gravity.
        effects: Torque effects beyond the rigid body, such as `Viscous`.
        parameters: Their linear parameters, in order.
        memory: Torques with states of their own.
        extra: Torques as functions, written with `oed.dynamics.scalars`.
    """

    robot: Robot
    effects: tuple[Effect, ...] = ()
    parameters: tuple[float, ...] = ()
    memory: tuple[MemoryTorque, ...] = ()
    extra: tuple[ExtraTorque, ...] = ()

    def __post_init__(self) -> None:
        expected = sum(len(effect.parameters) for effect in self.effects)
        if len(self.parameters) != expected:
            raise ValueError(f"{len(self.parameters)} parameters for {expected} effect columns")

    @property
    def memory_states(self) -> int:
        """Number of memory states."""
        return sum(memory.states for memory in self.memory)

    def torque(self, state: State, memory: Sequence[Scalar]) -> list[Scalar]:
        """Torque of every joint at one instant."""
        rigid = inverse_dynamics(self.robot, state.q, state.dq, state.ddq)
        return self.add_hidden_torque(state, memory, rigid)

    def add_hidden_torque(
        self, state: State, memory: Sequence[Scalar], rigid: Sequence[Scalar]
    ) -> list[Scalar]:
        """What all but the rigid body needs, added to the rigid body's torque."""
        total = list(rigid)
        value = iter(self.parameters)
        for effect in self.effects:
            for by_joint in effect.entries(state):
                size = float(next(value))
                for joint, entry in by_joint.items():
                    total[joint] = add(total[joint], mul(size, entry))
        for piece, own in self._by_memory(memory):
            for joint, torque in piece.torque(state, own).items():
                total[joint] = add(total[joint], torque)
        for extra in self.extra:
            for joint, torque in extra(state, rigid).items():
                total[joint] = add(total[joint], torque)
        return total

    def memory_rate(self, state: State, memory: Sequence[Scalar]) -> list[Scalar]:
        """Time derivative of all memory states."""
        return [r for piece, own in self._by_memory(memory) for r in piece.rate(state, own)]

    def acceleration(self) -> casadi.Function:
        """(t, q, dq, memory, applied torque) -> ddq, as a function of symbols."""
        n = self.robot.n
        t, q, dq, memory, state = self._symbols()
        ddq, applied = casadi.vertcat(*state.ddq), casadi.SX.sym("u", n)
        torque = casadi.vertcat(*self.torque(state, casadi.vertsplit(memory)))
        inertia = casadi.jacobian(torque, ddq)
        found = casadi.DM.zeros(n)
        for _ in range(NEWTON_STEPS if casadi.depends_on(inertia, ddq) else 1):
            rest = casadi.substitute(torque, ddq, found)
            found = found + _solve(casadi.substitute(inertia, ddq, found), applied - rest)
        return casadi.Function("acceleration", [t, q, dq, memory, applied], [found], {"cse": True})

    def memory_rates(self) -> casadi.Function:
        """(t, q, dq, memory) -> rate of the memory and its own derivative by each state."""
        t, q, dq, memory, state = self._symbols()
        rate = casadi.vertcat(casadi.SX(0, 1), *self.memory_rate(state, casadi.vertsplit(memory)))
        decay = casadi.diag(casadi.jacobian(rate, memory))
        return casadi.Function("memory_rates", [t, q, dq, memory], [rate, decay], {"cse": True})

    def fastest_memory(self) -> float:
        """Greatest decay rate of a memory state per unit of speed [1/rad]."""
        return max((piece.fastest for piece in self.memory), default=0.0)

    def mass_matrix(
        self, q: Float[ndarray, "points joints"]
    ) -> Float[ndarray, "points joints joints"]:
        """Of the rigid body at many positions [kg m^2 and the like]."""
        n, points = self.robot.n, len(q)
        rest = self.robot.with_gravity(np.zeros(3))
        position = list(np.ascontiguousarray(q.T))
        matrix = np.empty((points, n, n))
        for j in range(n):
            unit = [float(i == j) for i in range(n)]
            for i, torque in enumerate(inverse_dynamics(rest, position, [0.0] * n, unit)):
                matrix[:, i, j] = torque
        return matrix

    def _symbols(self) -> tuple[casadi.SX, casadi.SX, casadi.SX, casadi.SX, State]:
        n = self.robot.n
        t, q, dq = casadi.SX.sym("t"), casadi.SX.sym("q", n), casadi.SX.sym("dq", n)
        ddq, memory = casadi.SX.sym("ddq", n), casadi.SX.sym("z", self.memory_states)
        state = State(t, casadi.vertsplit(q), casadi.vertsplit(dq), casadi.vertsplit(ddq))
        return t, q, dq, memory, state

    def _by_memory(self, memory: Sequence[Scalar]) -> list[tuple[MemoryTorque, Sequence[Scalar]]]:
        pairs, start = [], 0
        for piece in self.memory:
            pairs.append((piece, memory[start : start + piece.states]))
            start += piece.states
        return pairs


def _solve(matrix: casadi.SX, right: casadi.SX) -> casadi.SX:
    """M x = b by L D L', which adds no operation for structural zeros."""
    D, LT, p = casadi.ldl(matrix)
    return casadi.ldl_solve(right, D, LT, p)
