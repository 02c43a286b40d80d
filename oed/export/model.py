"""A torque model with numbers: what an identification, a diagnosis or a feasible estimate hands on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects import with_columns
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.known_torque import KnownTorque
from oed.robot import Robot


@dataclass(frozen=True)
class Ranges:
    """Least and largest value of each joint that an estimate has seen.

    Attributes:
        q: (n, 2) position [rad or m].
        dq: (n, 2) velocity [rad/s or m/s].
        ddq: (n, 2) acceleration [rad/s^2 or m/s^2].
        tau: (n, 2) torque [N m or N].
    """

    q: Float[ndarray, "joints 2"]
    dq: Float[ndarray, "joints 2"]
    ddq: Float[ndarray, "joints 2"]
    tau: Float[ndarray, "joints 2"]

    @classmethod
    def of(cls, motions: Sequence[Motion], torques: Sequence[Float[ndarray, "_ joints"]]) -> Ranges:
        """The ranges of some recordings: their motions and torques."""
        signals = ([getattr(motion, x) for motion in motions] for x in ("q", "dq", "ddq"))
        whole = [np.concatenate(list(parts)) for parts in (*signals, torques)]
        return cls(*(np.stack([x.min(axis=0), x.max(axis=0)], axis=1) for x in whole))


@dataclass(frozen=True)
class ShapeEstimate:
    """A nonlinear parameter of an effect as it was estimated.

    Attributes:
        name: In words.
        unit: SI unit.
        value: In the unit.
        std: Standard deviation; None where the data tell none.
        note: Why not.
    """

    name: str
    unit: str
    value: float
    std: float | None
    note: str | None = None


@dataclass(frozen=True)
class Origin:
    """Where a model's numbers come from.

    Attributes:
        command: That found them, such as "oed identify".
        data: Name of the data set.
        method: Estimator, weights and covariance in words.
        date: When, in UTC.
        commit: Of the code; None outside a checkout.
        seed: Of everything random; None where nothing was.
        versions: Of the packages.
    """

    command: str
    data: str
    method: str
    date: str
    commit: str | None
    seed: int | None
    versions: dict[str, str]


@dataclass(frozen=True)
class Model:
    """A torque model with numbers for its parameters, and what is known of these.

    Attributes:
        torque_model: The robot with all effects, and what measurement does.
        parameters: (p,) of all its columns; those that are regrouped into others are zero.
        covariance: (p, p), zero where a parameter was not estimated; None where none was found.
        estimated: (p,) which were.
        is_feasible: Whether every body of it can exist.
        validity: What the data visited; None where that is not known.
        origin: Where the numbers come from.
        shapes: Of each effect, then of each measurement effect, its nonlinear parameters.
    """

    torque_model: TorqueModel
    parameters: Float[ndarray, " p"]
    covariance: Float[ndarray, "p p"] | None
    estimated: Bool[ndarray, " p"]
    is_feasible: bool
    validity: Ranges | None
    origin: Origin
    shapes: tuple[tuple[ShapeEstimate, ...], ...] = ()

    def __post_init__(self) -> None:
        count = len(self.torque_model.parameters)
        if len(self.parameters) != count or len(self.estimated) != count:
            raise ValueError(
                f"{len(self.parameters)} values, {len(self.estimated)} marks: the torque model has "
                f"{count} parameters"
            )

    @property
    def robot(self) -> Robot:
        """The machine, with the inertials of its file."""
        return self.torque_model.robot

    @property
    def std(self) -> Float[ndarray, " p"]:
        """Standard deviation of each parameter; NaN where none is known."""
        if self.covariance is None:
            return np.full(len(self.parameters), np.nan)
        return np.where(self.estimated, np.sqrt(np.diag(self.covariance)), np.nan)

    def torque(
        self,
        q: Float[ndarray, "samples joints"],
        dq: Float[ndarray, "samples joints"],
        ddq: Float[ndarray, "samples joints"],
        *,
        t: Float[ndarray, " samples"] | None = None,
    ) -> Float[ndarray, "samples joints"]:
        """Predicted torque of every joint, as the recordings would show it [N m or N].

        Args:
            q: (N, n) position [rad or m].
            dq: (N, n) velocity.
            ddq: (N, n) acceleration.
            t: (N,) time [s]; a sample a second if None. Effects with a memory, such as a delay, need
                the true one.
        """
        instants = np.arange(len(q), dtype=float) if t is None else t
        return self.torque_model.torque(self.parameters, Motion(instants, q, dq, ddq))

    def to_estimate(self) -> tuple[TorqueModel, KnownTorque]:
        """What is estimated anew where an estimate starts from this model, and what stays.

        Shapes and measurement effects stay; so do terms that claim no physics, numbers and all.
        """
        whole = self.torque_model
        pairs = [(e, self.parameters[place]) for e, place in with_columns(whole.effects)]
        kept = [(effect, own) for effect, own in pairs if not effect.has_physics]
        fitted = tuple(effect for effect, _ in pairs if effect.has_physics)
        numbers = np.concatenate([np.zeros(0), *(own for _, own in kept)])
        known = KnownTorque(tuple(effect for effect, _ in kept), numbers)
        return dataclasses.replace(whole, effects=fitted), known

    def parameters_of(self, torque_model: TorqueModel) -> Float[ndarray, " parameters"]:
        """Values of another model's parameters, whose effects are some of these."""
        own = {
            id(e): self.parameters[place] for e, place in with_columns(self.torque_model.effects)
        }
        return np.concatenate([np.zeros(0), *(own[id(e)] for e in torque_model.effects)])

    def shapes_of(self, torque_model: TorqueModel) -> tuple[tuple[ShapeEstimate, ...], ...]:
        """Nonlinear parameters of another model's effects, as far as they are these."""
        every = (*self.torque_model.effects, *self.torque_model.measurement)
        known = dict(zip(map(id, every), self.shapes, strict=False))
        asked = (*torque_model.effects, *torque_model.measurement)
        return tuple(known.get(id(effect), ()) for effect in asked)
