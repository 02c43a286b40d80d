"""The robot of a model.json: kinematics, inertials, limits, and its own file."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

from oed.export.model_record import (
    DescriptionRecord,
    JointRecord,
    LimitsRecord,
    ModelFileError,
    ModelRecord,
    RobotRecord,
)
from oed.robot import Joint, JointLimits, Robot
from oed.robot.description import RobotDescription
from oed.robot.limits import LIMITED


def robot_record(robot: Robot, home: Path) -> RobotRecord:
    """What the file says of a robot; its folder is seen from `home`."""
    joints = [
        JointRecord(**{x: _plain(getattr(joint, x)) for x in JointRecord.__struct_fields__})
        for joint in robot.joints
    ]
    return RobotRecord(
        name=robot.name,
        source=Path(robot.source).name,
        joints=joints,
        inertials=robot.parameters.tolist(),
        limits=LimitsRecord(**{x: pairs_of(getattr(robot.limits, x)) for x in LIMITED}),
        held=robot.held,
        description=_description_record(robot.description, home),
    )


def _description_record(file: RobotDescription | None, home: Path) -> DescriptionRecord | None:
    if file is None:
        return None
    return DescriptionRecord(
        format=file.format,
        text=file.text,
        sha256=_digest(file.text),
        file=file.place.name,
        folder=os.path.relpath(file.place.parent.resolve(), home),
    )


def robot_of(record: ModelRecord, folder: Path) -> Robot:
    """The robot of a file that lies in a folder.

    Raises:
        ModelFileError: If its parts contradict each other.
    """
    own = record.robot
    try:
        joints = tuple(
            Joint(**{x: _array(getattr(joint, x)) for x in JointRecord.__struct_fields__})
            for joint in own.joints
        )
        limits: dict[str, Any] = {x: bounds_of(getattr(own.limits, x)) for x in LIMITED}
        return Robot(
            name=own.name,
            joints=joints,
            parameters=np.array(own.inertials),
            gravity=np.array(record.gravity),
            limits=JointLimits(**limits),
            source=own.source,
            locked=tuple(own.held),
            locked_at=tuple(own.held.values()),
            description=_description_of(own.description, folder),
        )
    except (ValueError, IndexError) as error:
        raise ModelFileError(f"robot: {error}") from error


def _description_of(record: DescriptionRecord | None, folder: Path) -> RobotDescription | None:
    if record is None:
        return None
    if _digest(record.text) != record.sha256:
        raise ModelFileError("robot.description.text is damaged: it does not have its own sha256")
    path = folder / record.folder / record.file
    return RobotDescription(record.file, path, path, record.format, record.text)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, ndarray) else value


def _array(value: Any) -> Any:
    return np.array(value) if isinstance(value, list) else value


def pairs_of(bounds: ndarray) -> list[list[float | None]]:
    """Bounds as the file has them: null is none."""
    return [[float(x) if np.isfinite(x) else None for x in row] for row in bounds]


def bounds_of(pairs: list[list[float | None]]) -> ndarray:
    """The same read."""
    free = (-np.inf, np.inf)
    rows = [[f if x is None else x for x, f in zip(p, free, strict=True)] for p in pairs]
    return np.array(rows).reshape(-1, 2)
