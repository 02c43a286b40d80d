"""What every torque effect offers, and the state that it is written in."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.parameter import Demand, Parameter, not_negative
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import Scalar, add, mean_sign, mul, sign, tanh

REMEMBERED = 32  # signs of a motion's velocities, each with some width
# What a robot file and its readers know of a joint besides its bodies: dry friction, viscous
# friction, inertia of a rotor.
JointTerm = Literal["friction", "damping", "armature"]
# What a controller compensates: torque of bodies, what depends on position alone, what brakes or
# drives, inertia beside the bodies'.
Part = Literal["body", "position", "friction", "inertia"]
Columns = Sequence[Mapping[int, Scalar]]


@dataclass(frozen=True)
class State:
    """Joint coordinates in components: each an (N,) array, a float or a CasADi scalar.

    Attributes:
        t: Time [s].
        q: Position of each joint [rad or m].
        dq: Velocity of each joint.
        ddq: Acceleration of each joint.
        sign_width: Velocity over which a solver's sign is smoothed, tanh(v / width)
            [rad/s]; 0 for the exact sign with sign(0) = 0.
        averaged: Whether signs are means over the step of a sampled motion.
        sampled: The motion that this is the state along, if it is known.
        temperature: (N, n) of each joint or its motor [degrees Celsius]; None if not measured.
    """

    t: Scalar
    q: Sequence[Scalar]
    dq: Sequence[Scalar]
    ddq: Sequence[Scalar]
    sign_width: float = 0.0
    averaged: bool = False
    sampled: Motion | None = None
    temperature: Float[ndarray, "samples joints"] | None = None

    @classmethod
    def along(cls, motion: Motion, sign_width: float = 0.0) -> State:
        """The state at all instants of a sampled motion."""
        averaged, temperature = motion.averaged, motion.temperature
        return cls(motion.t, *motion.components, sign_width, averaged, motion, temperature)

    def sign(self, velocity: Scalar, width: float = 0.0) -> Scalar:
        """Direction of motion, smoothed over the wider of `width` and `sign_width`."""
        widest = max(width, self.sign_width)
        if self.averaged and isinstance(velocity, np.ndarray) and len(velocity) > 1:
            return self._mean_sign(velocity, widest)
        return tanh(velocity / widest) if widest > 0 else sign(velocity)

    def _mean_sign(self, velocity: ndarray, width: float) -> ndarray:
        """Remembered with the motion for its joints: a scan asks for the same ones at each value."""
        motion = self.sampled
        if motion is None or not any(velocity is own for own in motion.components[1]):
            return mean_sign(velocity, width)
        # No other array gets the identity of one that the motion keeps.
        key, signs = (id(velocity), width), motion.signs
        if key not in signs:
            if len(signs) >= REMEMBERED:
                signs.clear()
            signs[key] = mean_sign(velocity, width)
        return signs[key]

    def with_joint(self, joint: int, q: Scalar, dq: Scalar, ddq: Scalar) -> State:
        """The state with other coordinates of one joint."""

        def changed(own: Sequence[Scalar], new: Scalar) -> list[Scalar]:
            return [*own[:joint], new, *own[joint + 1 :]]

        there = (changed(self.q, q), changed(self.dq, dq), changed(self.ddq, ddq))
        known = (self.sign_width, self.averaged)
        return State(self.t, *there, *known, temperature=self.temperature)

    @cached_property
    def fingerprint(self) -> bytes | None:
        """What tells one sampled motion from another; None for symbols and single instants."""
        if not self._is_sampled():
            return None
        return self.motion("a fingerprint").fingerprint + repr(self.sign_width).encode()

    def motion(self, effect: str) -> Motion:
        """The sampled motion, for an effect that depends on more than one instant.

        Args:
            effect: Its name, for the message.

        Raises:
            ValueError: If the state is symbolic or one instant, so that it has no history.
        """
        if self.sampled is not None:
            return self.sampled
        if not self._is_sampled():
            raise ValueError(
                f"{effect} depends on the history of the motion: it can be evaluated on sampled "
                f"arrays, not on a symbolic state or a single instant"
            )
        q, dq, ddq = (np.stack(x, axis=1) for x in (self.q, self.dq, self.ddq))
        t, averaged = np.asarray(self.t, dtype=float), self.averaged
        return Motion(t, q, dq, ddq, averaged=averaged, temperature=self.temperature)

    def _is_sampled(self) -> bool:
        components = (*self.q, *self.dq, *self.ddq)
        return all(isinstance(x, np.ndarray) and x.ndim == 1 for x in components)


class Effect(ABC):
    """Columns of the torque regressor.

    Subclasses are frozen dataclasses whose fields are the joint and the nonlinear
    parameters, so that a model can be compared, printed, refined and written to a file.

    Attributes:
        name: Of the effect, for people.
        made_of: Dataclasses that fields may hold, beside numbers, text, arrays, robots and
            reference torques: so a file that has them can be read.
        joint_term: What of a robot file's joint its one parameter is; None if it is none.
        dissipates: Whether its parameters dissipate or store energy each: none can be negative.
        has_physics: Whether it claims to be more than a shape of the torque: a shape is kept as it was
            found where the rest is estimated anew.
        part: Of the torque, whose its columns are; see `parts`.
        offline: Why it cannot be worked out one instant after another, in words; empty if it can.
    """

    name: ClassVar[str]
    made_of: ClassVar[tuple[type, ...]] = ()
    joint_term: ClassVar[JointTerm | None] = None
    dissipates: ClassVar[bool] = False
    has_physics: ClassVar[bool] = True
    part: ClassVar[Part] = "friction"
    offline: ClassVar[str] = ""

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """The linear parameters, one a column."""

    @property
    @abstractmethod
    def depends_on(self) -> tuple[str, ...]:
        """Coordinates that the torque depends on, such as ("q_2", "dq_1")."""

    @property
    def beyond_state(self) -> tuple[str, ...]:
        """What of these no state of the joints tells: time and temperatures."""
        return tuple(x for x in self.depends_on if x == "time" or x.startswith("temperature"))

    def changes_along(self, coordinate: str) -> bool:
        """Whether its torque may change with a coordinate of a joint, such as "q_2"."""
        return coordinate in self.depends_on

    @property
    def leaving(self) -> Effect:
        """The effect as it is written to a file: without what only saves time."""
        return self

    @abstractmethod
    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """Torque per unit of each parameter: for each column, joint -> entry."""

    @property
    def demands(self) -> tuple[Demand, ...]:
        """What physics asks of the parameters, whatever the data say."""
        return not_negative(self.parameters) if self.dissipates else ()

    @property
    def parts(self) -> tuple[Part, ...]:
        """Of which part of the torque each column is."""
        return (self.part,) * len(self.parameters)

    @property
    def keeps(self) -> tuple[str, ...]:
        """What it keeps from one instant to the next, by name; most effects keep nothing."""
        return ()

    def begin(self, state: State) -> Sequence[Scalar]:  # noqa: ARG002  # of those that remember
        """What it keeps at the first instant of a motion."""
        return ()

    def recall(
        self,
        state: State,
        memory: Sequence[Scalar],  # noqa: ARG002
        step: float,  # noqa: ARG002
    ) -> tuple[Columns, Sequence[Scalar]]:
        """Its columns at one instant after others, and what it keeps at the next.

        Args:
            state: Of one instant, symbolic or in numbers.
            memory: As `begin`, or the instant before, left it.
            step: To the next instant [s].
        """
        return self.entries(state), ()

    def torque(
        self, state: State, coefficients: Float[ndarray, " columns"]
    ) -> Mapping[int, Scalar]:
        """Torque with these parameters, one a column: joint -> torque."""
        return combined(self.entries(state), coefficients)

    def recall_torque(
        self,
        state: State,
        memory: Sequence[Scalar],
        step: float,
        coefficients: Float[ndarray, " columns"],
    ) -> tuple[Mapping[int, Scalar], Sequence[Scalar]]:
        """The same one instant after others; arguments as of `recall`."""
        columns, following = self.recall(state, memory, step)
        return combined(columns, coefficients), following


def combined(columns: Columns, coefficients: Float[ndarray, " columns"]) -> dict[int, Scalar]:
    """Torque of some columns with their parameters: joint -> torque."""
    result: dict[int, Scalar] = {}
    for size, entry in zip(coefficients.tolist(), columns, strict=True):
        for joint, column in entry.items():
            result[joint] = add(result.get(joint, 0.0), mul(size, column))
    return result


def with_columns(effects: Iterable[Effect]) -> Iterator[tuple[Effect, slice]]:
    """Effects, each with where its columns stand among those of all."""
    start = 0
    for effect in effects:
        stop = start + len(effect.parameters)
        yield effect, slice(start, stop)
        start = stop


def recall_effects(
    effects: Sequence[Effect],
    coefficients: Float[ndarray, " columns"],
    state: State,
    memory: Sequence[Scalar],
    step: float,
) -> tuple[dict[int, Scalar], list[Scalar]]:
    """Torque of several effects at one instant after others, and what they remember at the next.

    Args:
        effects: One after another, in columns and in memory.
        coefficients: Of all their columns.
        state: As of `Effect.recall`, and so are the next two.
        memory: Of all of them.
        step: To the next instant [s].
    """
    result: dict[int, Scalar] = {}
    following: list[Scalar] = []
    start = 0
    for effect, place in with_columns(effects):
        stop = start + len(effect.keeps)
        own, kept = effect.recall_torque(state, memory[start:stop], step, coefficients[place])
        for joint, torque in own.items():
            result[joint] = add(result.get(joint, 0.0), torque)
        following += kept
        start = stop
    return result, following
