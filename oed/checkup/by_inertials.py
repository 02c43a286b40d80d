"""Causes that leave every fit as it is, and that the robot file's own inertials tell.

All signs, all scales, and gravity where the motion does not tell it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy import ndarray

from oed.checkup.cause import Cause
from oed.checkup.change import Change
from oed.checkup.projection import TELLING, Projection
from oed.checkup.suspicion import UNITS, is_on_earth, suspicions
from oed.estimation.dissipation import CLEAR_SHARE, LEAST_SHARE
from oed.experiment.dataset import DataSet

# Inertials of robot files, and even placeholders, give a joint's torque to its order of magnitude.
MAGNITUDE = np.sqrt(10.0)
OTHER_UNIT = 10.0  # farther from 1 than any such file


def all_reversed(dataset: DataSet, projection: Projection) -> Cause | None:
    """Every joint that tells has the file's torque with the opposite sign, and friction drives."""
    telling = projection.opposed
    if not len(telling):
        return None
    if (projection.braking > CLEAR_SHARE).any():
        return None  # where friction brakes the sign is right
    if not (projection.is_driven or (projection.friction < LEAST_SHARE and len(telling) > 1)):
        return None
    names = dataset.robot.joint_names
    shown = ", ".join(f"{projection.correlation[j]:.2f} at {names[j]}" for j in telling)
    evidence = f"correlation with the torque of the robot file's own inertials {shown}"
    if projection.is_driven:
        evidence += "; friction would drive the joints instead of braking them"
    every = f"tau_1 ... tau_{len(names)}" if len(names) > 1 else "tau_1"
    return Cause("sign", "all torques have the opposite sign", f"reverse {every}", evidence)


def gravity_reversed(
    dataset: DataSet, projection: Projection, under: Callable[[Change], Projection]
) -> Cause | None:
    """Every joint that tells has the file's torque with the opposite sign, and as it is with another gravity.

    Friction brakes: under torques of the opposite sign it would drive.

    Args:
        dataset: As read.
        projection: Under the gravity that is declared.
        under: The same under that of a change.
    """
    telling = projection.opposed
    if len(telling) < 2 or projection.friction < LEAST_SHARE:
        return None
    ways = [s for s in suspicions(dataset) if s.kind == "gravity"]
    found = [(s, under(s.change).correlation[telling]) for s in ways]
    right = [(s, correlation) for s, correlation in found if (correlation >= TELLING).all()]
    if len(right) != 1:
        return None
    ((suspicion, after),) = right
    names = dataset.robot.joint_names
    shown = ", ".join(
        f"{projection.correlation[j]:.2f} to {x:.2f} at {names[j]}"
        for j, x in zip(telling, after, strict=True)
    )
    evidence = f"correlation with the torque of the robot file's own inertials {shown}"
    return Cause("gravity", suspicion.text, suspicion.remedy, evidence)


def all_scaled(dataset: DataSet, projection: Projection) -> Cause | None:
    """Every joint that tells has the file's torque divided by its gear ratio, or by one factor."""
    if dataset.robot.in_amperes:
        return None  # of currents no scale is known
    gravity = dataset.robot.gravity
    if np.any(gravity) and not is_on_earth(gravity):
        return None  # its own factor passes for one of the torques
    telling = projection.telling & (projection.slope > 0)
    ratios = dataset.drive.gear_ratio
    if ratios is not None:
        geared = np.flatnonzero(telling & (np.abs(ratios) > 1))
        slope = projection.slope[geared]
        if len(geared) and _all_of_size(slope * np.abs(ratios[geared])) and _is_other(slope):
            return _gear_left_out(dataset, projection, geared)
    joints = np.flatnonzero(telling)
    slope = projection.slope[joints]
    if len(joints) < 2 or not _is_other(slope):
        return None
    for factor, words in UNITS.items():
        if _all_of_size(slope / factor):
            text = f"the torques are in {words}"
            return Cause(
                "scale", text, f"divide them by {factor:g}", _slopes(dataset, slope, joints)
            )
    middle = float(np.exp(np.mean(np.log(slope))))
    # Inertials that are too small by as much are placeholders; too large ones are not made up.
    if middle > 1 or not _all_of_size(slope / middle):
        return None
    text = f"the torques are {middle:.2g} of what the robot file's inertials need: a gear or a unit"
    remedy = (
        "convert them to N m at the joint; current_to_torque holds the gear ratio: N m at the joint "
        "per A of the motor"
    )
    return Cause("scale", text, remedy, _slopes(dataset, slope, joints))


def _gear_left_out(dataset: DataSet, projection: Projection, joints: ndarray) -> Cause:
    ratios = np.abs(np.asarray(dataset.drive.gear_ratio))
    shown = ", ".join(
        f"{dataset.robot.joint_names[j]} {projection.slope[j]:.3g} (1/{ratios[j]:g} is {1 / ratios[j]:.3g})"
        for j in joints
    )
    has_constant = dataset.drive.current_to_torque is not None
    remedy = (
        "multiply current_to_torque in [drive] by gear_ratio: it is N m at the joint per A of the motor"
        if has_constant
        else "multiply the tau columns by the gear ratios: they are torques at the joint"
    )
    return Cause(
        "gear",
        "the torques are those of the motors: the gear ratio is left out",
        remedy,
        f"measured torque over that of the robot file's own inertials: {shown}",
    )


def _slopes(dataset: DataSet, slope: ndarray, joints: ndarray) -> str:
    names = dataset.robot.joint_names
    shown = ", ".join(f"{names[j]} {x:.3g}" for j, x in zip(joints, slope, strict=True))
    return f"measured torque over that of the robot file's own inertials: {shown}"


def _all_of_size(ratio: ndarray) -> bool:
    return bool(np.all((ratio > 1 / MAGNITUDE) & (ratio < MAGNITUDE)))


def _is_other(slope: ndarray) -> bool:
    return bool(np.all(slope < 1 / OTHER_UNIT) or np.all(slope > OTHER_UNIT))
