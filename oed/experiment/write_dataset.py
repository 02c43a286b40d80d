"""Write a data set as a folder that `read_dataset` returns unchanged."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Literal

import numpy as np
import tomli_w
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.column_names import joint_columns
from oed.experiment.dataset import DataSet
from oed.experiment.drive import DRIVE_KEYS
from oed.experiment.manifest import COMBINATION, FORMAT, LIMIT_KEYS, MANIFEST
from oed.experiment.recording import Recording
from oed.robot import JointSum, Robot, load_robot

# Elements of URDF, SDF and MJCF by which a robot's file names others.
NAMES_FILES = re.compile(r"<(mesh|texture|uri|include|hfield|skin)\b")


def write_dataset(
    dataset: DataSet,
    directory: str | Path,
    *,
    file_format: Literal["csv", "parquet"] = "csv",
) -> None:
    """Write a data set to a new folder: all of it, or nothing.

    The robot is written as its source: the built-in's name, or a copy of its file, which of xacro
    and of a table of Denavit-Hartenberg parameters is the URDF that they become.
    Torques go back to currents where the drive has `current_to_torque`. Columns that the
    reader did not use are not in `dataset` and so are not written.

    Args:
        dataset: What to write.
        directory: Folder to create; it must not exist, or be empty.
        file_format: Kind of the recordings' files.

    Raises:
        ValueError: If the folder is in use, there is no recording, a recording's name is no
            relative path, or the robot is not the one that its source describes.
    """
    target = Path(directory)
    check_new_folder(target)
    _check(dataset)
    limits = _changed_limits(dataset.robot)
    target.parent.mkdir(parents=True, exist_ok=True)
    # A sibling is on the same file system, so that the rename is one step.
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.name}-") as temporary:
        folder = Path(temporary) / target.name
        folder.mkdir()
        manifest = _manifest(dataset, limits, file_format)
        manifest |= write_robot(dataset.robot, folder, target)
        (folder / MANIFEST).write_text(tomli_w.dumps(manifest), encoding="utf-8")
        for recording in dataset.recordings:
            path = folder / f"{recording.name}.{file_format}"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_columns(path, _columns(recording, dataset.drive.current_to_torque))
        folder.rename(target)


def check_new_folder(target: Path) -> None:
    """Raise `ValueError` if a folder holds anything, or is a file."""
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise ValueError(f"{target} exists and is not an empty folder; nothing was overwritten")


def write_columns(path: Path, values: Mapping[str, ndarray]) -> None:
    """Write columns of equal length so that reading returns the same numbers to the last bit."""
    from pandas import DataFrame  # noqa: PLC0415  # a second that reading a data set does not need

    frame = DataFrame(dict(values))
    if path.suffix.lower() == ".parquet":
        frame.to_parquet(path, index=False)
    else:
        frame.to_csv(path, index=False, lineterminator="\n")


def _check(dataset: DataSet) -> None:
    if not dataset.recordings:
        raise ValueError(f"data set {dataset.name!r} holds no recording to write")
    for recording in dataset.recordings:
        path = PurePosixPath(recording.name)
        if path.is_absolute() or ".." in path.parts or not path.name:
            raise ValueError(f"recording name {recording.name!r} is no file name in the folder")


def _changed_limits(robot: Robot) -> dict[str, Float[ndarray, "joints 2"]]:
    """The limits that differ from those of the robot's source."""
    original = load_robot(
        robot.source,
        joints=robot.joint_names,
        locked=robot.held,
        gravity=tuple(robot.gravity),
        place=None if robot.description is None else robot.description.place,
    )
    if not np.array_equal(original.parameters, robot.parameters):
        raise ValueError(
            f"the inertial parameters of robot {robot.name!r} are not those of {robot.source}, "
            "so they would be lost; write the data set with the robot as loaded"
        )
    return {
        kind: getattr(robot.limits, kind)
        for kind in LIMIT_KEYS
        if not np.array_equal(getattr(original.limits, kind), getattr(robot.limits, kind))
    }


def write_robot(robot: Robot, folder: Path, target: Path) -> dict[str, str]:
    """Leave the robot's file in a folder.

    Args:
        robot: To write.
        folder: To write to.
        target: Folder that it is moved to when it is whole.

    Returns:
        What a `dataset.toml` there says of it: `robot`, and where that names other files `robot_from`,
        beside which they are.
    """
    file = robot.description
    if file is None:
        return {"robot": robot.source}
    name = f"robot{file.path.suffix}" if file.is_as_written else f"robot.{file.format}"
    if file.is_as_written:
        shutil.copyfile(file.path, folder / name)
    else:
        (folder / name).write_text(file.text, encoding="utf-8")
    said = {"robot": name}
    if NAMES_FILES.search((folder / name).read_text(encoding="utf-8", errors="replace")):
        said["robot_from"] = os.path.relpath(file.place.resolve(), target.resolve())
    return said


def _manifest(
    dataset: DataSet, limits: dict[str, Float[ndarray, "joints 2"]], file_format: str
) -> dict[str, object]:
    manifest: dict[str, object] = {
        "format": FORMAT,
        "name": dataset.name,
        "source": dataset.source,
        "licence": dataset.licence,
        "robot": "",
        "joints": list(dataset.robot.joint_names),
        "gravity": dataset.robot.gravity.tolist(),
        "torque": dataset.torque,
    }
    stated: dict[str, object] = {kind: _bounds(kind, b) for kind, b in limits.items()}
    if dataset.robot.limits.sums:
        names = dataset.robot.joint_names
        stated[COMBINATION] = [_combination(each, names) for each in dataset.robot.limits.sums]
    if stated:
        manifest["limits"] = stated
    drive = {key: getattr(dataset.drive, key) for key in DRIVE_KEYS}
    drive = {key: values.tolist() for key, values in drive.items() if values is not None}
    if drive:
        manifest["drive"] = drive
    if dataset.torque == "current" and not drive.get("current_to_torque"):
        manifest["units"] = {"tau": list(dataset.torque_units)}
    if dataset.robot.locked:
        manifest["fixed"] = dataset.robot.held
    manifest["recording"] = [_entry(r, file_format) for r in dataset.recordings]
    return manifest


def _bounds(kind: str, bounds: Float[ndarray, "joints 2"]) -> list[object]:
    is_symmetric = np.array_equal(-bounds[:, 0], bounds[:, 1])
    return bounds[:, 1].tolist() if is_symmetric and kind != "position" else bounds.tolist()


def _combination(each: JointSum, names: tuple[str, ...]) -> dict[str, object]:
    factors = {name: f for name, f in zip(names, each.factors, strict=True) if f}
    bounds = [each.lower, each.upper]
    return {"joints": list(factors), "factors": list(factors.values()), "position": bounds}


def _entry(recording: Recording, file_format: str) -> dict[str, object]:
    entry: dict[str, object] = {
        "file": f"{recording.name}.{file_format}",
        "role": recording.role,
    }
    if recording.period is not None:
        entry["period"] = recording.period
    return entry


def _columns(
    recording: Recording, current_to_torque: Float[ndarray, " joints"] | None
) -> dict[str, ndarray]:
    tau = recording.tau
    if current_to_torque is not None:
        tau = _currents(tau, current_to_torque)
    columns = {"t": recording.t}
    for quantity, values in (
        ("q", recording.q),
        ("dq", recording.dq),
        ("ddq", recording.ddq),
        ("tau", tau),
        ("temperature", recording.temperature),
    ):
        if values is not None:
            names = joint_columns(quantity, values.shape[1])
            columns |= dict(zip(names, values.T, strict=True))
    if recording.repetition is not None:
        columns["repetition"] = recording.repetition
    return columns


def _currents(
    tau: Float[ndarray, "samples joints"], factor: Float[ndarray, " joints"]
) -> Float[ndarray, "samples joints"]:
    """Currents [A] whose product with the factor is `tau` to the last bit, where one exists.

    Division alone can be off by a rounding; torques that were read from currents have an
    exact one among its neighbours.
    """
    nearest = tau / factor
    currents = nearest.copy()
    for direction in (np.inf, -np.inf):
        neighbour = nearest
        for _ in range(2):
            neighbour = np.nextafter(neighbour, direction)
            better = (currents * factor != tau) & (neighbour * factor == tau)
            currents = np.where(better, neighbour, currents)
    return currents
