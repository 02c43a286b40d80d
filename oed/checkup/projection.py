"""The measured torque beside what the robot file's own inertials need, joint by joint.

A regression of each joint's torque on the torque of the file's inertials, on the joint's friction and on
a constant: its slope is -1 where the sign is reversed, the inverse of the gear ratio where a drive
constant leaves the gear out, a power of ten where a unit is another. A joint tells where the file's
torque explains most of what friction does not; placeholders for inertials mostly do not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.dynamics.effects import RigidBody
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.dissipation import CLEAR_SHARE, LEAST_SHARE
from oed.estimation.triangular import factor_of
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import Role

SUSPECT = 0.7  # correlation with the wrong sign: half of that variance, reason enough for a look
TELLING = 0.9  # correlation: four fifths of the variance that friction and a constant leave


@dataclass(frozen=True)
class Projection:
    """What a regression of the torque on the file's own inertials says of each joint.

    Attributes:
        slope: (n,) of the measured torque over the file's; NaN where the file needs none.
        correlation: (n,) of both, without what friction and a constant explain.
        braking: (n,) power that friction takes from each joint, over the mean of |tau dq|; negative
            where it drives it.
        friction: The same of all joints together.
        needed: (n,) rms torque of the file's inertials [N m].
        measured: (n,) rms torque [N m].
    """

    slope: Float[ndarray, " joints"]
    correlation: Float[ndarray, " joints"]
    braking: Float[ndarray, " joints"]
    friction: float
    needed: Float[ndarray, " joints"]
    measured: Float[ndarray, " joints"]

    @property
    def telling(self) -> Bool[ndarray, " joints"]:
        """Joints whose torque the file's inertials explain, up to sign and scale."""
        return np.abs(self.correlation) >= TELLING

    @property
    def opposed(self) -> Int[ndarray, " telling"]:
        """The joints that tell, where all have the file's torque with the opposite sign; else none."""
        telling = np.flatnonzero(self.telling)
        return telling[:0] if (self.correlation[telling] > 0).any() else telling

    @property
    def contrary(self) -> Bool[ndarray, " joints"]:
        """Joints whose torque is the file's with the other sign, or that friction clearly drives."""
        return (self.correlation <= -SUSPECT) | (self.braking < -CLEAR_SHARE)

    @property
    def is_driven(self) -> bool:
        """Whether friction drives the arm as a whole."""
        return self.friction < -LEAST_SHARE


def project(
    model: TorqueModel, recordings: Mapping[Role, tuple[ProcessedRecording, ...]]
) -> Projection:
    """Regress the torque of all recordings on the file's inertials.

    Args:
        model: With a rigid body and friction.
        recordings: By role, of one band.
    """
    every = [recording for group in recordings.values() for recording in group]
    rigid = TorqueModel(model.robot, (RigidBody(model.robot),))
    friction = TorqueModel(
        model.robot, tuple(e for e in model.effects if not isinstance(e, RigidBody))
    )
    factors: list[Float[ndarray, "width width"]] = []
    for recording in every:
        for rows in _rows(rigid, friction, recording):
            before = factors or [own[:0] for own in rows]
            factors = [factor_of(pair) for pair in zip(before, rows, strict=True)]
    samples = sum(len(recording) for recording in every)
    found = [_regress(factor / np.sqrt(samples)) for factor in factors]
    tau = np.concatenate([recording.tau for recording in every])
    dq = np.concatenate([recording.motion.dq for recording in every])
    slope, correlation, taken = (np.array(x) for x in zip(*found, strict=True))
    power = np.mean(np.abs(tau * dq), axis=0)
    total = float(power.sum())
    return Projection(
        slope=slope,
        correlation=correlation,
        braking=np.divide(taken, power, out=np.zeros_like(taken), where=power > 0),
        friction=float(taken.sum()) / total if total > 0 else 0.0,
        needed=np.array([np.linalg.norm(f[:, -2]) for f in factors]) / np.sqrt(samples),
        measured=np.sqrt(np.mean(tau**2, axis=0)),
    )


def _rows(
    rigid: TorqueModel, friction: TorqueModel, recording: ProcessedRecording
) -> Iterator[list[Float[ndarray, "samples width"]]]:
    """Of each joint [friction's columns | 1 | velocity | file's torque | torque], a piece at a time."""
    parameters = rigid.robot.parameters
    file = recording.columns(
        lambda m: rigid.columns(m) @ parameters[:, None], remembers=rigid.remembers
    )[:, :, 0]
    for place, beside in recording.pieces(friction.columns, remembers=friction.remembers):
        dq, needed, tau = recording.motion.dq[place], file[place], recording.tau[place]
        yield [
            np.column_stack([beside[:, j], np.ones(len(tau)), dq[:, j], needed[:, j], tau[:, j]])
            for j in range(tau.shape[1])
        ]


def _regress(factor: Float[ndarray, "width width"]) -> tuple[float, float, float]:
    """Slope, partial correlation, and the mean power that the columns beside take.

    Args:
        factor: Of a joint's rows as `_rows` has them, of their mean over samples: columns of it have the
            inner products of theirs.
    """
    file, tau, dq = factor[:, -2], factor[:, -1], factor[:, -3]
    others = factor[:, :-3][:, np.any(factor[:, :-3] != 0, axis=0)]
    scale = np.linalg.norm(others, axis=0)
    pair = np.column_stack([file, tau])
    left = pair - others @ (np.linalg.lstsq(others / scale, pair, rcond=None)[0] / scale[:, None])
    squares, product = left[:, 0] @ left[:, 0], left[:, 0] @ left[:, 1]
    size = np.sqrt(squares * (left[:, 1] @ left[:, 1]))
    slope = product / squares if size > 0 else np.nan
    rest = tau - (slope * file if size > 0 else 0.0)
    coefficients = np.linalg.lstsq(others / scale, rest, rcond=None)[0] / scale
    # The constant comes last, and is no friction.
    taken = (others[:, :-1] @ coefficients[:-1]) @ dq
    return float(slope), float(product / size) if size > 0 else 0.0, float(taken)
