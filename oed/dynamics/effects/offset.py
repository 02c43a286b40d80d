"""A constant torque: sensor zero, current offset or asymmetric Coulomb friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.scalars import Scalar


@dataclass(frozen=True)
class TorqueOffset(Effect):
    """A constant on one joint.

    Coulomb friction that differs between the two directions is the mean of both times
    sgn(dq) plus this constant: no motion tells the two apart.
    """

    joint: int
    name = "torque_offset"
    part = "position"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The offset."""
        return (Parameter(f"offset_{self.joint + 1}", "N m", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Nothing."""
        return ()

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:  # noqa: ARG002  # the same torque in every state
        """1."""
        return [{self.joint: 1.0}]
