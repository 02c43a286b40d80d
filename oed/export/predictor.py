"""A model as functions of one instant: tau = f(q, dq, ddq, memory), for controllers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.array_function import array_function
from oed.dynamics.effects import State
from oed.dynamics.effects.measurement_effect import Instants
from oed.dynamics.online import (
    Offline,
    as_recorded,
    gravity_torque,
    of_the_arm,
    offline,
    part_torque,
    without_offline,
)
from oed.dynamics.scalars import Scalar
from oed.dynamics.torque_model import TorqueModel
from oed.export.model import Model

Torques = Callable[[State, Sequence[Scalar]], list[Scalar]]


@dataclass(frozen=True)
class Predictor:
    """A model one instant after another, with what it keeps from each to the next.

    Attributes:
        model: Without what needs a whole recording.
        parameters: (p,) of its columns.
        step: Between two instants [s].
        left_out: What needs a whole recording, and why.
    """

    model: TorqueModel
    parameters: Float[ndarray, " p"]
    step: float
    left_out: tuple[Offline, ...] = ()

    @classmethod
    def of(cls, model: Model, step: float) -> Predictor:
        """The predictor of a model at a controller's rate.

        Args:
            model: To predict with.
            step: Between two instants [s].

        Raises:
            ValueError: If the step is not positive.
        """
        if not step > 0:
            raise ValueError(f"{step=} must be positive")
        kept, parameters = without_offline(model.torque_model, model.parameters)
        return cls(kept, parameters, step, offline(model.torque_model))

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.model.robot.n

    @cached_property
    def recorded(self) -> Instants:
        """Torque as recordings show it: delays and gains of the measurement are in it."""
        return as_recorded(self.model, self.parameters, self.step)

    @cached_property
    def arm(self) -> Instants:
        """Torque that the arm needs, whatever its measurement does."""
        return of_the_arm(self.model.effects, self.parameters, self.n, self.step)

    @cached_property
    def functions(self) -> dict[str, casadi.Function]:
        """As CasADi functions of (n,) q, dq, ddq and what is kept, by name.

        `torque` is what recordings show, `torque_begin` its memory at the first instant; `arm`, with
        `arm_begin`, what the arm needs. Of `arm` there are four parts, which add up to it.
        """
        names = ("torque", "torque_begin", "arm", "arm_begin", *self._parts)
        return {name: self.function(name) for name in names}

    def function(self, name: str) -> casadi.Function:
        """One of these."""
        if name in self._parts:
            return self._part(name, self._parts[name])
        whole, _, begun = name.partition("_")
        own = self.recorded if whole == "torque" else self.arm
        return self._begun(name, own) if begun else self._recalled(name, own)

    @property
    def _parts(self) -> dict[str, Torques]:
        known = (self.model, self.parameters)

        def gravity(state: State, memory: Sequence[Scalar]) -> list[Scalar]:
            return gravity_torque(*known, state, memory=memory, step=self.step)

        def part(name: str) -> Torques:
            return lambda state, memory: part_torque(
                name,  # pyright: ignore[reportArgumentType]
                *known,
                state,
                memory=memory,
                step=self.step,
            )

        def inertia(state: State, memory: Sequence[Scalar]) -> list[Scalar]:
            parts = (part("body")(state, memory), part("inertia")(state, memory))
            weight = gravity(state, memory)
            return [a + b - w for a, b, w in zip(*parts, weight, strict=True)]

        return {
            "gravity": gravity,
            "position": part("position"),
            "friction": part("friction"),
            "inertia": inertia,
        }

    def _recalled(self, name: str, own: Instants) -> casadi.Function:
        inputs, state, memory = self._symbols(len(own.keeps))
        torque, following = own.recall(state, memory)
        outputs = [_column(torque), _column(following)]
        names = ["q", "dq", "ddq", "memory"]
        return casadi.Function(name, inputs, outputs, names, ["tau", "next"], {"cse": True})

    def _begun(self, name: str, own: Instants) -> casadi.Function:
        inputs, state, _ = self._symbols(0)
        outputs = [_column(own.begin(state))]
        return casadi.Function(name, inputs[:3], outputs, ["q", "dq", "ddq"], ["memory"])

    def _part(self, name: str, torques: Torques) -> casadi.Function:
        inputs, state, memory = self._symbols(len(self.arm.keeps))
        outputs = [_column(torques(state, memory))]
        names = ["q", "dq", "ddq", "memory"]
        return casadi.Function(name, inputs, outputs, names, ["tau"], {"cse": True})

    def _symbols(self, kept: int) -> tuple[list[casadi.SX], State, list[casadi.SX]]:
        inputs = [casadi.SX.sym(name, self.n) for name in ("q", "dq", "ddq")]
        inputs.append(casadi.SX.sym("memory", kept))
        q, dq, ddq, memory = (casadi.vertsplit(x) if x.numel() else [] for x in inputs)
        return inputs, State(0.0, q, dq, ddq), memory


def _column(values: Sequence[Scalar]) -> casadi.SX:
    return casadi.vertcat(casadi.SX(0, 1), *values)


class Running:
    """A predictor in use from Python, which hands its memory on by itself."""

    def __init__(self, predictor: Predictor) -> None:
        self._torque, self._begin = (
            array_function(predictor.function(name)) for name in ("torque", "torque_begin")
        )
        self._memory: Float[ndarray, " kept"] | None = None

    def __call__(
        self,
        q: Float[ndarray, " joints"],
        dq: Float[ndarray, " joints"],
        ddq: Float[ndarray, " joints"],
    ) -> Float[ndarray, " joints"]:
        """Torque at the next instant [N m or N]."""
        if self._memory is None:
            self._memory = self._begin(q, dq, ddq)[0].ravel()
        torque, kept = self._torque(q, dq, ddq, self._memory)
        self._memory = kept.ravel()
        return torque.ravel()
