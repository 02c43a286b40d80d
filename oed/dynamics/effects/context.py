"""What is known when an effect is tried: the model so far and what the data cover."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, with_columns
from oed.dynamics.effects.friction import Coulomb, Viscous
from oed.dynamics.effects.offset import TorqueOffset
from oed.dynamics.effects.on_reference import with_ends
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.transmission import TransmissionChange
from oed.dynamics.motion import Motion, follow_one_another
from oed.dynamics.torque_model import TorqueModel

# Share of the samples up to which speed and torque count: beyond lie starts and gaps of the log.
HIGHEST = 0.995
LEAST_WARMING = 0.5  # [K] of some joint: thermometers read a tenth, and wander by a few of them
Known = tuple[tuple[Effect, Float[ndarray, " _"]], ...]


@dataclass(frozen=True)
class Drives:
    """What is known of the drives.

    Attributes:
        gear_ratio: Motor turns a joint turn, None where unknown.
        of_motors: Whether torques are those of the motors, and no sensors': what is coupled in
            the drives is then mixed in them.
    """

    gear_ratio: tuple[float, ...] | None = None
    of_motors: bool = False


@dataclass(frozen=True, eq=False)
class Context:
    """What is known when an effect is tried: the model so far and what the data cover.

    Attributes:
        model: The torque model before the effect.
        parameters: (p,) its current estimate; base parameters with the rest zero will do.
        duration: Of the longest recording [s].
        position_range: (n, 2) least and largest position [rad].
        top_speed: (n,) largest speed, but for a few samples [rad/s].
        top_acceleration: (n,) likewise [rad/s^2].
        peak_torque: (n,) largest predicted torque, but for a few samples [N m].
        drives: What is known of them.
        session: First and last time of recordings that one clock timed, one after another [s];
            None for a single recording, or if every one starts its own clock.
        recordings: How many show the effect.
        between: When one of these ended and the next had not begun, since the session's start [s].
        ordered: Whether a clock or repetitions tell how these follow one another. Where that is
            only assumed, what changes between two of them passes for anything in which they differ.
        beside: Effects found so far, each with its coefficients: delay, gain and load feel
            their torque too.
        temperature_range: (n, 2) least and largest temperature of each joint [degrees Celsius];
            None where one recording or another has none, or no joint's changes.
    """

    model: TorqueModel
    parameters: Float[ndarray, " parameters"]
    duration: float
    position_range: Float[ndarray, "joints 2"]
    top_speed: Float[ndarray, " joints"]
    top_acceleration: Float[ndarray, " joints"]
    peak_torque: Float[ndarray, " joints"]
    drives: Drives = Drives()
    session: tuple[float, float] | None = None
    recordings: int = 1
    between: tuple[float, ...] = ()
    ordered: bool = True
    beside: Known = ()
    temperature_range: Float[ndarray, "joints 2"] | None = None

    @classmethod
    def of(
        cls,
        model: TorqueModel,
        parameters: Float[ndarray, " parameters"],
        motions: Sequence[Motion],
        drives: Drives = Drives(),
        beside: Known = (),
        *,
        later: Sequence[Motion] = (),
        ordered: bool = True,
        cut: float = 0.0,
    ) -> Context:
        """The context of recordings, one motion each.

        Args:
            model: As the attribute, and so are the next.
            parameters: Of the model.
            motions: Of the recordings that show the effect.
            drives: As the attribute.
            beside: As the attribute.
            later: Of further recordings, which tell whether the clock of a single one goes on, and
                must have a temperature if it is to count.
            ordered: As the attribute.
            cut: Of each recording, before its motion's first sample [s]: a session begins with the
                log.
        """
        if not motions:
            raise ValueError("a context needs at least one motion to say what is covered")
        reference = _reference(model, parameters, beside)
        states = ("q", "dq", "ddq")
        q, dq, ddq = (np.concatenate([getattr(m, x) for m in motions]) for x in states)
        torque = np.concatenate([reference.parts(motion).sum(axis=2) for motion in motions])
        session = _session(motions if len(motions) > 1 else [*motions, *later], cut)
        return cls(
            model=model,
            parameters=parameters,
            duration=float(max(motion.t[-1] - motion.t[0] for motion in motions)),
            position_range=np.stack([q.min(axis=0), q.max(axis=0)], axis=1),
            top_speed=np.quantile(np.abs(dq), HIGHEST, axis=0),
            top_acceleration=np.quantile(np.abs(ddq), HIGHEST, axis=0),
            peak_torque=np.quantile(np.abs(torque), HIGHEST, axis=0),
            drives=drives,
            session=session,
            recordings=len(motions),
            between=() if session is None else _between(motions, session[0]),
            ordered=ordered,
            beside=beside,
            temperature_range=_temperature_range(motions, later),
        )

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.model.robot.n

    @cached_property
    def reference(self) -> ReferenceTorque:
        """The model with the current estimate put in, and the effects found so far."""
        return _reference(self.model, self.parameters, self.beside)

    @cached_property
    def unyielding(self) -> ReferenceTorque:
        """The same without gears that yield: what such a gear is driven by."""
        if not any(isinstance(effect, TransmissionChange) for effect, _ in self.beside):
            return self.reference
        rest = tuple(k for k in self.beside if not isinstance(k[0], TransmissionChange))
        return _reference(self.model, self.parameters, rest)

    def sign_width(self, joint: int) -> float:
        """Width over which the model's own Coulomb friction turns its sign [rad/s]."""
        widths = [
            effect.width
            for effect in self.model.effects
            if isinstance(effect, Coulomb) and effect.joint == joint
        ]
        return max(widths, default=0.0)

    def coulomb(self, joint: int) -> float:
        """Current estimate of Coulomb friction [N m]; 0 if the model has none."""
        return self._friction[Coulomb].get(joint, 0.0)

    def viscous(self, joint: int) -> float:
        """Current estimate of viscous friction [N m s/rad]; 0 if the model has none."""
        return self._friction[Viscous].get(joint, 0.0)

    def friction_at_top_speed(self, joint: int) -> float:
        """Coulomb and viscous friction at the fastest that the joint moves [N m]."""
        return self.coulomb(joint) + self.viscous(joint) * float(self.top_speed[joint])

    def has_offset(self, joint: int) -> bool:
        """Whether the model already has a constant torque on the joint."""
        return any(
            isinstance(effect, TorqueOffset) and effect.joint == joint
            for effect in self.model.effects
        )

    @cached_property
    def _friction(self) -> dict[type[Coulomb] | type[Viscous], dict[int, float]]:
        """Current estimates by kind and joint; several terms of one kind add up."""
        found: dict[type[Coulomb] | type[Viscous], dict[int, float]] = {Coulomb: {}, Viscous: {}}
        for effect, place in with_columns(self.model.effects):
            for kind, by_joint in found.items():
                if isinstance(effect, kind):
                    before = by_joint.get(effect.joint, 0.0)
                    by_joint[effect.joint] = before + float(self.parameters[place.start])
        return found


def _reference(
    model: TorqueModel, parameters: Float[ndarray, " parameters"], beside: Known
) -> ReferenceTorque:
    effects = (*model.effects, *with_ends([effect for effect, _ in beside]))
    values = np.concatenate([parameters, *(coefficients for _, coefficients in beside)])
    return ReferenceTorque.of(model.robot, effects, values)


def _temperature_range(
    motions: Sequence[Motion], later: Sequence[Motion]
) -> Float[ndarray, "joints 2"] | None:
    """Least and largest temperature of each joint over motions; None where none is of use."""
    measured = [m.temperature for m in motions if m.temperature is not None]
    if len(measured) < len(motions) or any(m.temperature is None for m in later):
        return None
    whole = np.concatenate(measured)
    found = np.stack([whole.min(axis=0), whole.max(axis=0)], axis=1)
    return found if np.ptp(found, axis=1).max() >= LEAST_WARMING else None


def _session(motions: Sequence[Motion], cut: float) -> tuple[float, float] | None:
    """First and last time of motions that follow one another on one clock, what was cut included [s]."""
    if len(motions) < 2 or not follow_one_another([motion.t for motion in motions]):
        return None
    return (
        min(float(motion.t[0]) for motion in motions) - cut,
        max(float(motion.t[-1]) for motion in motions) + cut,
    )


def _between(motions: Sequence[Motion], start: float) -> tuple[float, ...]:
    """Middle of the pause before each motion but the first, since a start [s]."""
    ordered = sorted((motion.t for motion in motions), key=lambda t: t[0])
    pairs = itertools.pairwise(ordered)
    return tuple(float(before[-1] + after[0]) / 2 - start for before, after in pairs)
