"""Read a data set from its folder; see `oed.errors.DataSetError` for what a fault says."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from oed.counted import counted
from oed.errors import DataSetError, OedError
from oed.experiment.dataset import DataSet
from oed.experiment.drive import DRIVE_KEYS, Drive
from oed.experiment.limit_checks import check_limits
from oed.experiment.logs import Log, held, read_log
from oed.experiment.manifest import MANIFEST, Manifest, read_manifest
from oed.experiment.read_recording import read_recording
from oed.experiment.recording import Recording
from oed.experiment.recording_checks import check_signals
from oed.experiment.temperature import temperature_of
from oed.experiment.toml_table import nearest
from oed.experiment.torque_unit import in_its_unit
from oed.robot import JointSum, Robot, load_robot

STILL = 0.01  # [rad or m] a joint that travels no further may be left out as locked


def read_dataset(directory: str | Path, *, joints: Sequence[str] | None = None) -> DataSet:
    """Read a folder with a `dataset.toml`, a robot and recordings.

    Args:
        directory: The folder.
        joints: Names of the joints to keep, in this order; all if None. The others are
            locked where they stood, and must have stood still.

    Returns:
        The data set with torques in N m (currents are multiplied by `current_to_torque`),
        columns and drive of the kept joints only, and limits of the data set where it
        states any, else of the robot's file.

    Raises:
        DataSetError: At the first fault, naming file, row and column.
    """
    folder = _folder(directory)
    return dataset_of(read_manifest(folder), folder, joints=joints)


def read_robot(directory: str | Path, *, joints: Sequence[str] | None = None) -> Robot:
    """The robot of a data set, whether or not anything is recorded yet.

    Args:
        directory: The folder, with a `dataset.toml` and the robot's file.
        joints: Names of the joints to keep, in this order; all if None. The others are held
            as `oed.robot.load_robot` holds joints that are not named.

    Returns:
        The robot with the data set's gravity, and its limits where it states any.

    Raises:
        DataSetError: At the first fault, naming file and key.
    """
    folder = _folder(directory)
    manifest = read_manifest(folder)
    every = tuple(range(len(manifest.joints)))
    robot = _load_robot(folder, manifest, every, {})
    _check_all_listed(folder, manifest, robot)
    kept = _kept(folder, manifest, joints)
    return robot if kept == every else _load_robot(folder, manifest, kept, {})


def _folder(directory: str | Path) -> Path:
    folder = Path(directory)
    if not folder.is_dir():
        what = "no such folder"
        if folder.exists():
            making = f"oed import {folder.name} --robot arm.urdf --out mydata/"
            what = f"is a file: give the folder of a data set; {making} makes one of a log"
        raise DataSetError(what, file=str(folder))
    return folder


def dataset_of(
    manifest: Manifest,
    folder: Path,
    *,
    joints: Sequence[str] | None = None,
    logs: Mapping[Path, Log] | None = None,
) -> DataSet:
    """Read what a manifest lists, whether or not it is written yet.

    Args:
        manifest: The content of a `dataset.toml`.
        folder: That its paths are relative to.
        joints: As of `read_dataset`.
        logs: Those that are open already, by their resolved paths.

    Raises:
        DataSetError: As `read_dataset`.
    """
    if not manifest.recordings:
        message = "missing; nothing is recorded yet: list each log in a [[recording]] table"
        raise DataSetError(message, file=str(folder / MANIFEST), column="recording")
    every = tuple(range(len(manifest.joints)))
    robot = _load_robot(folder, manifest, every, {})
    _check_format(folder, manifest, robot)
    _check_all_listed(folder, manifest, robot)
    recordings = _read_recordings(folder, manifest, robot, logs or {})
    kept = _kept(folder, manifest, joints)
    if kept != every:
        standing = _standing(manifest, recordings, kept)
        robot = _load_robot(folder, manifest, kept, standing)
        recordings = tuple(_select(recording, kept) for recording in recordings)
    for recording in recordings:
        check_signals(recording.q, recording.tau, recording.source, robot)
    robot = in_its_unit(robot, manifest, recordings)
    return DataSet(
        name=manifest.name,
        source=manifest.source,
        licence=manifest.licence,
        robot=robot,
        torque=manifest.torque,
        drive=_select_drive(manifest.drive, kept),
        recordings=recordings,
    )


def _load_robot(
    folder: Path, manifest: Manifest, kept: Sequence[int], locked: Mapping[str, float]
) -> Robot:
    """The robot with the kept joints active and the limits of the data set."""
    is_builtin = manifest.robot.startswith("builtin:")
    source = manifest.robot if is_builtin else folder / manifest.robot
    place = folder / manifest.robot_from if manifest.robot_from else None
    names = [manifest.joints[j] for j in kept]
    limits = {kind: bounds[list(kept)] for kind, bounds in manifest.limits.items()}
    try:
        locked = {**manifest.fixed, **locked}
        robot = load_robot(
            source, joints=names, locked=locked, gravity=tuple(manifest.gravity), place=place
        )
        check_limits(limits, robot, str(folder / MANIFEST))
        held = robot.held
        sums = [JointSum.of(s.factors, s.bounds, names, held) for s in manifest.sums]
        own = [each for each in sums if each is not None]
        return robot.with_limits(robot.limits.with_(**limits).with_sums(own))
    except DataSetError:
        raise
    except (OedError, ValueError, RuntimeError, OSError) as error:
        is_of_names = any(word in str(error) for word in ("no joint", "named twice"))
        is_fixed = any(repr(name) in str(error) for name in manifest.fixed)
        key = "fixed" if is_fixed else "joints" if is_of_names else "robot"
        message = f"the robot cannot be used: {error}"
        raise DataSetError(message, file=str(folder / MANIFEST), column=key) from error


def _check_format(folder: Path, manifest: Manifest, robot: Robot) -> None:
    try:
        manifest.log.check(robot)
    except ValueError as error:
        raise DataSetError(str(error), file=str(folder / MANIFEST), column="units") from error


def _check_all_listed(folder: Path, manifest: Manifest, robot: Robot) -> None:
    """A joint that nobody logged may have stood anywhere: its inertia is then unknown."""
    # One that mimics another is where that puts it.
    followers = {} if robot.description is None else robot.description.mimics
    missing = [name for name in robot.locked if name not in (*manifest.fixed, *followers)]
    if missing:
        message = (
            f"lists {counted(robot.n, 'joint')}, {manifest.robot} has {robot.n + len(missing)} that "
            f"move; not listed: {', '.join(missing)}. Record these too, or say in [fixed] where "
            f"they stood, as in {missing[0]} = 0.0"
        )
        raise DataSetError(message, file=str(folder / MANIFEST), column="joints")


def _read_recordings(
    folder: Path, manifest: Manifest, robot: Robot, given: Mapping[Path, Log]
) -> tuple[Recording, ...]:
    """Every recording; a log is parsed once, and let go with the last that is cut from it."""
    files = _files(folder, manifest)
    left = Counter(files)
    logs = dict(given)
    recordings = []
    for entry, real in zip(manifest.recordings, files, strict=True):
        if real not in logs:
            logs[real] = held(read_log(folder / entry.file))
        recordings.append(
            read_recording(
                logs[real], entry, robot, manifest.log, drive=manifest.drive, torque=manifest.torque
            )
        )
        left[real] -= 1
        if not left[real]:
            del logs[real]
    return tuple(recordings)


def _files(folder: Path, manifest: Manifest) -> tuple[Path, ...]:
    """The log of each recording; one log has one name."""
    names: dict[Path, str] = {}
    files = []
    for entry in manifest.recordings:
        path = folder / entry.file
        try:
            files.append(path.resolve())
        except (OSError, RuntimeError, ValueError) as error:
            raise DataSetError(f"cannot be found: {error}", file=str(path)) from error
        if names.setdefault(files[-1], entry.file) != entry.file:
            message = f"{entry.file!r} and {names[files[-1]]!r} are the same file; list it once"
            raise DataSetError(message, file=str(folder / MANIFEST), column="recording.file")
    return tuple(files)


def _kept(folder: Path, manifest: Manifest, joints: Sequence[str] | None) -> tuple[int, ...]:
    if joints is None:
        return tuple(range(len(manifest.joints)))
    if not joints or len(set(joints)) != len(joints):
        raise DataSetError(
            f"choose at least one joint, each once; chosen: {list(joints)}",
            file=str(folder / MANIFEST),
            column="joints",
        )
    for name in joints:
        if name not in manifest.joints:
            message = f"no joint {name!r} to choose; {nearest(name, manifest.joints)}"
            raise DataSetError(message, file=str(folder / MANIFEST), column="joints")
    return tuple(manifest.joints.index(name) for name in joints)


def _standing(
    manifest: Manifest, recordings: Sequence[Recording], kept: Sequence[int]
) -> dict[str, float]:
    """Positions [rad or m] of the joints left out, which must stand still throughout."""
    left_out = [j for j in range(len(manifest.joints)) if j not in kept]
    standing = {}
    for j in left_out:
        name = manifest.joints[j]
        start = float(recordings[0].q[0, j])
        for recording in recordings:
            travel = float(np.abs(recording.q[:, j] - start).max())
            if travel > STILL:
                message = (
                    f"joint {name!r} was not chosen but moves {travel:.4g} (at most {STILL:g} "
                    "counts as still), so it cannot be locked; choose it too"
                )
                raise DataSetError(message, file=recording.source, column=f"q_{j + 1}")
        samples = np.concatenate([recording.q[:, j] for recording in recordings])
        standing[name] = float(samples.mean())
    return standing


def _select(recording: Recording, kept: Sequence[int]) -> Recording:
    columns = list(kept)
    return dataclasses.replace(
        recording,
        temperature=temperature_of(recording, columns),
        q=recording.q[:, columns],
        tau=recording.tau[:, columns],
        dq=None if recording.dq is None else recording.dq[:, columns],
        ddq=None if recording.ddq is None else recording.ddq[:, columns],
    )


def _select_drive(drive: Drive, kept: Sequence[int]) -> Drive:
    given = {key: getattr(drive, key) for key in DRIVE_KEYS}
    return Drive(**{key: None if v is None else v[list(kept)] for key, v in given.items()})
