"""Over which velocity friction turns its sign, joint by joint, from the data.

A drive turns within thousandths of a rad/s, an arm whose encoder is coarse seems to take hundredths. A width
that is wrong leaves an error at every change of direction, which is larger than the noise and does not
average out in a short motion. Of a few widths each joint takes the one that leaves least of its torque,
with all other parameters free and its own: that needs no gains, no masses and no other joint.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.effects import Coulomb, Effect, RigidBody
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.feasible.data_factor import JointFactors
from oed.estimation.row_pieces import even_pieces
from oed.experiment.preparation.processed import ProcessedRecording

# [rad/s], at a slide that of a pinion: from a quiet drive to what hides behind a coarse encoder.
WIDTHS = (0.001, 0.003, 0.01, 0.02, 0.04, 0.08)


def choose_sign_widths(
    model: TorqueModel, columns: Int[ndarray, " base"], recordings: Sequence[ProcessedRecording]
) -> TorqueModel:
    """The model with each joint's friction turning its sign as the data say.

    Args:
        model: With any widths.
        columns: Of its columns that are estimated; of the rigid body's these count.
        recordings: Of the arm.
    """
    bodies, beside = _parted(model)
    kept = columns[columns < len(bodies.parameters)]
    turning = [_turning(beside, [width] * model.robot.n) for width in WIDTHS]
    parts: list[list[JointFactors]] = [[] for _ in WIDTHS]
    for recording in recordings:
        for place in even_pieces(len(recording), model.robot.n, len(kept)):
            rigid = recording.columns(
                lambda m: bodies.columns(m)[:, :, kept], remembers=bodies.remembers, rows=place
            )
            for found, each in zip(parts, turning, strict=True):
                found.append(_factors(each, rigid, recording, place))
    left = [[joint.remainder for joint in JointFactors.join(found).joints] for found in parts]
    best = np.argmin(left, axis=0)
    return _turning(model, [WIDTHS[k] for k in best])


def _factors(
    beside: TorqueModel,
    rigid: Float[ndarray, "samples joints columns"],
    recording: ProcessedRecording,
    place: slice,
) -> JointFactors:
    """Of some rows of a recording, each joint with parameters of its own."""
    columns = recording.columns(beside.columns, remembers=beside.remembers, rows=place)
    return JointFactors.of(np.concatenate([rigid, columns], axis=2), recording.tau[place])


def _parted(model: TorqueModel) -> tuple[TorqueModel, TorqueModel]:
    """The model's rigid body, which knows no sign, and all else, both seen as the whole is."""
    rigid = tuple(e for e in model.effects if isinstance(e, RigidBody))
    others = tuple(e for e in model.effects if not isinstance(e, RigidBody))
    return dataclasses.replace(model, effects=rigid), dataclasses.replace(model, effects=others)


def _turning(model: TorqueModel, widths: Sequence[float]) -> TorqueModel:
    """The model with these widths, one a joint [rad/s]."""

    def turned(effect: Effect) -> Effect:
        if not isinstance(effect, Coulomb | Stribeck):
            return effect
        joint = model.robot.joints[effect.joint]
        return dataclasses.replace(effect, width=joint.speed(widths[effect.joint]))

    return dataclasses.replace(model, effects=tuple(turned(e) for e in model.effects))
