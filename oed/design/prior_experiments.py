"""What earlier experiments tell, read back from their design files or from recorded motions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.problem import DesignProblem
from oed.design.trajectories.registry import restore_motion
from oed.dynamics.motion import Motion
from oed.errors import OedError, one_line
from oed.input_file import UnreadableFile, read_json

# A design has hundreds and five; beyond these, what is kept of every instant fills the memory.
MOST_INSTANTS = 100_000
RECORDED = "recorded"  # class of a file that holds a recorded motion, sample by sample


class OtherJoints(OedError):
    """The motion of a file is one of other joints."""


def prior_information(
    files: Sequence[str | Path], problem: DesignProblem
) -> Float[ndarray, "base base"]:
    """What the experiments of earlier design files tell about a problem's base parameters.

    Args:
        files: `design.json` of motions of the same joints, or motions that `check` leaves.
        problem: Its model and noise; the instants are those of each file.

    Raises:
        ValueError: If a file cannot be read as a design, or moves other joints.
    """
    return np.sum([_information_of(Path(file), problem) for file in files], axis=0)


def _information_of(file: Path, problem: DesignProblem) -> Float[ndarray, "base base"]:
    robot = problem.model.robot
    try:
        record = _object(read_json(file))
        if record.get("class") == RECORDED:
            return problem.fast.information(_recorded(record, problem))
        joints, name, count = record["joints"], record["class"], int(record["instants"])
        horizon = float(record["horizon"])
        given = {key: np.array(x, dtype=float) for key, x in record["coefficients"].items()}
    except FileNotFoundError as error:
        raise ValueError(f"{file}: no such file") from error
    except UnreadableFile as error:
        raise ValueError(str(error)) from error
    except OtherJoints as error:
        raise ValueError(f"{file}: {error}") from error
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{file}: not a design file: {one_line(repr(error))}") from error
    if joints != list(robot.joint_names):
        what = one_line(repr(joints))
        raise ValueError(f"{file}: it moves {what}, not {list(robot.joint_names)}")
    if not (0 < horizon < np.inf and 0 < count <= MOST_INSTANTS):
        raise ValueError(
            f"{file}: {horizon=} and {count} instants: both must be positive, and the instants at "
            f"most {MOST_INSTANTS}"
        )
    try:
        trajectory, z = restore_motion(name, horizon, problem.limits, given)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error
    if not np.isfinite(z).all():
        raise ValueError(f"{file}: a coefficient is not a finite number")
    return problem.fast.information(trajectory.motion(z, trajectory.instants(count)))


def _recorded(record: dict[str, Any], problem: DesignProblem) -> Motion:
    """The motion that a file holds sample by sample."""
    joints, names = record["joints"], list(problem.model.robot.joint_names)
    if joints != names:
        raise OtherJoints(f"it moves {one_line(repr(joints))}, not {names}")
    t, *signals = (np.array(record[key], dtype=float) for key in ("t", "q", "dq", "ddq"))
    if not 0 < len(t) <= MOST_INSTANTS:
        raise ValueError(f"{len(t)} instants")
    shapes = {signal.shape for signal in signals}
    if shapes != {(len(t), len(names))} or not all(np.isfinite(x).all() for x in (t, *signals)):
        raise ValueError(f"signals of {len(t)} instants have shapes {shapes}, or are not finite")
    return Motion(t, *signals)


def _object(value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(f"it holds {type(value).__name__}, not an object")
    return value
