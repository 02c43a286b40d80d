"""What cannot be right about a model or a name, though the data ask for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.evidence.proof import RoleProof
from oed.diagnosis.evidence.verdict import FoundEffect
from oed.dynamics.effects.gravity import LEVEL
from oed.robot import Robot

FAR_TILT = np.deg2rad(20.0)  # no mounting errs by that
NOTHING_EXPLAINED = 0.9  # ratio of the error where fitted to the torque: a fifth of its variance


def caveats(
    effects: Sequence[FoundEffect], proofs: Sequence[RoleProof], declared: Robot
) -> tuple[str, ...]:
    """Lines for whoever reads the diagnosis.

    Args:
        effects: What has a name.
        proofs: Errors before and after, of every role.
        declared: The robot, with the gravity that the data set declares.
    """
    joints = declared.joint_names
    return (*_of_model(proofs, joints), *_of_tilt(effects, declared), *_of_joint(effects, joints))


def _of_joint(effects: Sequence[FoundEffect], joints: Sequence[str]) -> Iterator[str]:
    for effect in effects:
        for rival in effect.rivals:
            own, other = effect.joint, rival.joint
            if rival.is_same and own is not None and other is not None and own != other:
                yield (
                    f"{effect.name}: at {joints[other]} it explains the same as at {joints[own]}, on any "
                    "motion: which of the two joints it is, these torques cannot tell"
                )


def _of_model(proofs: Sequence[RoleProof], joints: Sequence[str]) -> Iterator[str]:
    for proof in proofs:
        if proof.role != "estimation":
            continue
        for j in np.flatnonzero(proof.before > NOTHING_EXPLAINED * proof.torque).tolist():
            yield (
                f"{joints[j]}: the base model explains {_explained(proof, j):.0%} of its "
                "torque's variance where it was fitted: is it this robot's log, and are its columns in "
                "this order?"
            )


def _of_tilt(effects: Sequence[FoundEffect], declared: Robot) -> Iterator[str]:
    for effect in effects:
        if effect.name != GRAVITY:
            continue
        if np.linalg.norm(declared.gravity) < LEVEL:
            yield (
                "gravity is declared to be zero, and the arm feels some: state it in dataset.toml; the tilt "
                "is counted from the first joint's axis where no joint feels gravity along that"
            )
            continue
        angle = float(np.linalg.norm([p.value for p in effect.parameters if p.unit == "rad"]))
        if angle > FAR_TILT:
            yield (
                f"gravity_direction: a tilt of {np.rad2deg(angle):.0f} degrees is no error of mounting: time in "
                "another unit, another size of gravity, or a wrong axis in the robot's file look the "
                "same; check these, and the declared gravity"
            )


def _explained(proof: RoleProof, joint: int) -> float:
    return max(0.0, 1 - float(proof.before[joint] / proof.torque[joint]) ** 2)
