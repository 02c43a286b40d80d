"""Whether two data sets are of one arm in one unit, so that their difference is a load."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError
from oed.experiment.dataset import DataSet
from oed.robot import Robot

# Files of one arm that were written by two programs differ by rounding: 0.1 mrad and 0.1 mm.
SAME_PLACE = 1e-4
SAME_GRAVITY = 0.02  # [m/s^2]: 9.80 and 9.81 are one
SAME_POSTURE = 1e-3  # [rad or m] of joints that are held
SAME_CONSTANT = 1e-6  # relative
# Of all joints' torques: loads and motions differ by a factor of a few, units by a thousand.
OTHER_UNIT = 100.0


class OtherArm(OedError):
    """Two data sets that do not belong together."""


def check_same_arm(bare: DataSet, loaded: DataSet) -> tuple[str, ...]:
    """Refuse data sets of which one cannot tell what the other lacks.

    Args:
        bare: Of the arm alone.
        loaded: Of the arm with a load.

    Returns:
        What differs and does no harm, a line each.

    Raises:
        OtherArm: In one line that says what differs and what to do.
    """
    both = f"{bare.name} and {loaded.name}"
    notes = check_same_robot(bare.robot, loaded.robot, both)
    _check_units(bare, loaded, both)
    _check_sizes(bare, loaded, both)
    return notes


def check_same_robot(bare: Robot, loaded: Robot, both: str) -> tuple[str, ...]:
    """Refuse two robots of which one is not the other.

    Args:
        bare: The one.
        loaded: The other.
        both: What they are called, for the message.

    Returns:
        What differs and does no harm, a line each.

    Raises:
        OtherArm: In one line that says what differs and what to do.
    """
    _check_joints(bare, loaded, both)
    _check_places(bare, loaded, both)
    if not np.allclose(bare.gravity, loaded.gravity, atol=SAME_GRAVITY):
        raise OtherArm(
            f"{both}: gravity is {_listed(bare.gravity)} and {_listed(loaded.gravity)} "
            "m/s^2: the arm was mounted in another way; record both in one, or correct `gravity`"
        )
    held = bare.held
    moved = [n for n, at in loaded.held.items() if abs(held.get(n, at) - at) > SAME_POSTURE]
    return tuple(
        f"joint {name!r} is held at {held[name]:.4g} without and {loaded.held[name]:.4g} with "
        "the load: what that moves counts as load"
        for name in moved
    )


def _check_joints(bare: Robot, loaded: Robot, both: str) -> None:
    mine, theirs = bare.joint_names, loaded.joint_names
    if mine == theirs:
        return
    if sorted(mine) == sorted(theirs):
        raise OtherArm(
            f"{both}: the same joints in another order, {', '.join(mine)} and {', '.join(theirs)}; "
            "list `joints` and columns of both in one order"
        )
    raise OtherArm(
        f"{both}: other joints, {_only(mine, theirs)} and {_only(theirs, mine)}: these are two "
        "robots, or one of the data sets leaves joints out (--joints chooses them)"
    )


def _check_places(bare: Robot, loaded: Robot, both: str) -> None:
    for mine, theirs in zip(bare.joints, loaded.joints, strict=True):
        pairs = (
            (mine.R_PJ, theirs.R_PJ),
            (mine.p_PJ, theirs.p_PJ),
            (mine.axis, theirs.axis),
        )
        apart = max(float(np.abs(a - b).max()) for a, b in pairs)
        if mine.kind != theirs.kind or mine.parent != theirs.parent or apart > SAME_PLACE:
            what = (
                f"is {mine.kind} and {theirs.kind}"
                if mine.kind != theirs.kind
                else "hangs on other links"
                if mine.parent != theirs.parent
                else f"has another place or axis, by {apart:.2g} (m or direction)"
            )
            raise OtherArm(
                f"{both}: joint {mine.name!r} {what}: their robot files are of two robots; give both "
                "the same file"
            )


def _check_sizes(bare: DataSet, loaded: DataSet, both: str) -> None:
    sizes = [
        np.sqrt(np.mean(np.concatenate([r.tau for r in data.estimation]) ** 2, axis=0))
        for data in (bare, loaded)
        if data.estimation
    ]
    if len(sizes) < 2:
        return
    mine, theirs = sizes
    for ratios in (mine / theirs, theirs / mine):
        if (ratios > OTHER_UNIT).all():
            raise OtherArm(
                f"{both}: the torques of one are {np.median(ratios):.2g} times those of the other, at "
                "every joint: one of them is in another unit; correct [units] in its dataset.toml"
            )


def _check_units(bare: DataSet, loaded: DataSet, both: str) -> None:
    if bare.torque_units != loaded.torque_units:
        raise OtherArm(
            f"{both}: torque is in {_units(bare)} and in {_units(loaded)}; bring both to one unit by "
            "[drive] current_to_torque in dataset.toml"
        )
    mine, theirs = (d.drive.current_to_torque for d in (bare, loaded))
    if mine is None or theirs is None:
        is_same = True
    else:
        is_same = np.allclose(mine, theirs, rtol=SAME_CONSTANT)
    if not is_same:
        raise OtherArm(
            f"{both}: current_to_torque is {_listed(mine)} and {_listed(theirs)} N m/A: "
            "the drives are the same, so are their constants"
        )
    if bare.torque != loaded.torque:
        raise OtherArm(
            f"{both}: torque is {bare.torque} and {loaded.torque}: what sensors, currents and "
            "commands show differs by the friction between them; take both from one source"
        )


def _units(dataset: DataSet) -> str:
    return " and ".join(dict.fromkeys(dataset.torque_units))


def _only(mine: Sequence[str], theirs: Sequence[str]) -> str:
    own = [name for name in mine if name not in theirs]
    return ", ".join(own) if own else f"none but the {len(mine)} common ones"


def _listed(values: Float[ndarray, " k"] | None) -> str:
    return "[" + ", ".join(f"{x:.4g}" for x in (() if values is None else values)) + "]"
