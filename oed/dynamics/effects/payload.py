"""A payload that is taken up during a recording, and perhaps put down again."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oed.dynamics.effects.effect import Columns, Effect, Parameter, State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.thermal import since
from oed.dynamics.scalars import Scalar, at_least, mul
from oed.robot import Robot


@dataclass(frozen=True)
class PayloadChange(Effect):
    """Inertial columns of a link from a moment on, for good or for a while.

    A load adds its ten parameters to those of the link that holds it (Khalil, Gautier and
    Lemoine 2007; Swevers et al. 2002).

    Attributes:
        robot: The arm.
        link: Index of the joint whose body holds the load.
        moment: When it is taken up, since `start` [s].
        kept: Which of the ten standard parameters are columns; the rest make no torque of
            their own.
        start: Origin of `moment` [s]; None for the first sample of each recording.
        memory: Of the columns, which a search for the moment asks for again and again; none if None.
        held_for: How long it is held from the moment on [s].
    """

    robot: Robot
    link: int
    moment: float
    kept: tuple[int, ...] = tuple(range(10))
    start: float | None = None
    memory: ReferenceTorque | None = None
    held_for: float = np.inf
    name = "payload_change"
    part = "body"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Change of the link's standard parameters."""
        names, units = self.robot.parameter_names, self.robot.parameter_units
        chosen = [10 * self.link + k for k in self.kept]
        return tuple(Parameter(f"load_{names[c]}", units[c], self.link) for c in chosen)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Time and all joint coordinates."""
        n = self.robot.n
        return ("time", *(f"{x}_{i + 1}" for x in ("q", "dq", "ddq") for i in range(n)))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The link's columns where the load is held, zero before."""
        gate = self.held(state.t)
        if isinstance(gate, np.generic):  # NumPy's scalars do not meet symbols
            gate = float(gate)
        memory = self.memory or ReferenceTorque(self.robot)
        columns = memory.link_columns(state, self.link)
        return [{joint: mul(gate, entry) for joint, entry in columns[k].items()} for k in self.kept]

    @property
    def keeps(self) -> tuple[str, ...]:
        """Time since the start [s]."""
        return ("time of payload_change",)

    def begin(self, state: State) -> Sequence[Scalar]:  # noqa: ARG002  # whatever it is
        """None has gone by."""
        return (0.0,)

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[Columns, Sequence[Scalar]]:
        """The link's columns, if the load is held at that time."""
        since_then = dataclasses.replace(self, start=0.0, memory=None)
        now = dataclasses.replace(state, t=memory[0])
        return since_then.entries(now), (memory[0] + step,)

    def held(self, t: Scalar) -> Scalar:
        """1 while the load is held, 0 before and after.

        Args:
            t: Time of one recording [s].
        """
        along = since(t, self.start) - self.moment
        taken_up = at_least(along, 0.0)
        return taken_up if np.isinf(self.held_for) else taken_up - at_least(along, self.held_for)

    @property
    def leaving(self) -> PayloadChange:
        """The same without a memory."""
        return dataclasses.replace(self, memory=None)
