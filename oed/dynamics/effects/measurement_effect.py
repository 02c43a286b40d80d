"""What measurement does to a whole torque, along a recording and one instant after another."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects.effect import State
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import Scalar


@dataclass(frozen=True)
class Instants:
    """A torque that is worked out one instant after another.

    Attributes:
        keeps: What it keeps from one to the next, by name.
        begin: What it keeps at the first instant of a motion.
        recall: (state, memory) -> torque of every joint, and the memory at the next instant.
    """

    keeps: tuple[str, ...]
    begin: Callable[[State], list[Scalar]]
    recall: Callable[[State, Sequence[Scalar]], tuple[list[Scalar], list[Scalar]]]


class MeasurementEffect(ABC):
    """What measurement does to the whole model, such as a delay: it adds no column.

    `through` receives the function that evaluates columns, and may change the motion before or the
    columns after.

    Attributes:
        name: Of the effect, for people.
        made_of: As of an `Effect`.
        not_simulated: Why no simulation of the arm has it, in words.
    """

    name: ClassVar[str]
    made_of: ClassVar[tuple[type, ...]] = ()
    not_simulated: ClassVar[str] = "the recording shows it, the arm does not have it"

    @property
    def offline(self) -> str:
        """Why it cannot be worked out one instant after another, in words; empty if it can."""
        return ""

    def after(self, inner: Instants, joints: int, step: float) -> Instants:  # noqa: ARG002  # of those that can
        """A torque as this effect lets it be seen, one instant after another.

        Args:
            inner: The torque before.
            joints: How many.
            step: Between two instants [s].

        Raises:
            ValueError: If it cannot; `offline` says why.
        """
        raise ValueError(f"{self.name}: {self.offline or 'does not say how it goes on in time'}")

    def undone(
        self,
        t: Float[ndarray, " samples"],  # noqa: ARG002  # of those that move the torque
        tau: Float[ndarray, "samples joints"],
    ) -> Float[ndarray, "samples joints"]:
        """The torque that acted on the arm, from the recorded one.

        What cannot be undone, or does not change the torque itself, leaves it as it was recorded.

        Args:
            t: (N,) time [s].
            tau: (N, n) as it was recorded [N m or N].
        """
        return tau

    @property
    def leaving(self) -> MeasurementEffect:
        """The effect as it is written to a file: without what only saves time."""
        return self

    @abstractmethod
    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
        rigid: Bool[ndarray, " columns"],
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns as this effect lets them be seen.

        Args:
            columns: Of a model, or of a part of one.
            motion: As recorded.
            rigid: (p,) which of the columns are the rigid body's.
        """
