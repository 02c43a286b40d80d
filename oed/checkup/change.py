"""A change of a log and of the gravity declared beside it, tried as if it put the log right."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel


@dataclass(frozen=True)
class Change:
    """How a log is read.

    Attributes:
        source: Whose column each of n joints' torque is taken to be.
        gain: That it is multiplied by.
        order: Whose position each joint's is taken to be.
        turn: Sign that it is multiplied by.
        gravity: In the base frame [m/s^2]; None as declared.
    """

    source: tuple[int, ...]
    gain: tuple[float, ...]
    order: tuple[int, ...]
    turn: tuple[float, ...]
    gravity: tuple[float, float, float] | None = None

    @classmethod
    def none(cls, joints: int) -> Change:
        """The log as it is."""
        same, ones = tuple(range(joints)), (1.0,) * joints
        return cls(same, ones, same, ones)

    @classmethod
    def of_torque(cls, joints: int, joint: int, factor: float) -> Change:
        """The torque of one joint multiplied."""
        gain = tuple(factor if j == joint else 1.0 for j in range(joints))
        return dataclasses.replace(cls.none(joints), gain=gain)

    @property
    def of_columns(
        self,
    ) -> tuple[tuple[int, ...], tuple[float, ...], tuple[float, float, float] | None]:
        """What it changes of the model's columns: two that agree in it share them."""
        return self.order, self.turn, self.gravity

    @property
    def moves(self) -> bool:
        """Whether positions are not as logged."""
        return min(self.turn) < 0 or self.order != tuple(range(len(self.order)))

    def then(self, later: Change) -> Change:
        """This change, and another of the log that it leaves."""
        return Change(
            tuple(self.source[k] for k in later.source),
            tuple(g * self.gain[k] for g, k in zip(later.gain, later.source, strict=True)),
            tuple(self.order[k] for k in later.order),
            tuple(t * self.turn[k] for t, k in zip(later.turn, later.order, strict=True)),
            self.gravity if later.gravity is None else later.gravity,
        )

    def differs_in_signs(self, other: Change) -> bool:
        """Whether the two differ in nothing but signs, which with a joint's both turned agree."""
        one, two = (np.multiply(c.gain, c.turn) for c in (self, other))
        rest = [(c.source, c.order, c.gravity) for c in (self, other)]
        return rest[0] == rest[1] and bool((one == two).all() or (one == -two).all())

    def differs_in_size(self, other: Change) -> bool:
        """Whether both do nothing but multiply the torque of the same one joint."""
        none = Change.none(len(self.gain))
        rest = [dataclasses.replace(c, gain=none.gain) for c in (self, other)]
        one, two = (np.flatnonzero(np.array(c.gain) != 1).tolist() for c in (self, other))
        return rest == [none, none] and len(one) == 1 and one == two

    def motion(self, motion: Motion) -> Motion:
        """The motion that is meant."""
        order, turn = list(self.order), np.array(self.turn)
        moved = (x[:, order] * turn for x in (motion.q, motion.dq, motion.ddq))
        return Motion(motion.t, *moved)

    def torque(self, tau: Float[ndarray, "samples joints"]) -> Float[ndarray, "samples joints"]:
        """The torque that is meant."""
        return tau[:, list(self.source)] * np.array(self.gain)

    def by_column(self, of_joints: Float[ndarray, " joints"]) -> Float[ndarray, " joints"]:
        """What is said of each joint, at the column of the log that its torque is taken from."""
        found = np.empty_like(of_joints)
        found[list(self.source)] = of_joints
        return found

    def model(self, model: TorqueModel) -> TorqueModel:
        """The model under the gravity that is meant."""
        if self.gravity is None:
            return model
        return model.with_robot(model.robot.with_gravity(np.array(self.gravity)))
