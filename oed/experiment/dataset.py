"""One robot and its recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from oed.errors import OedError
from oed.experiment.drive import DRIVE_KEYS, TORQUE_KINDS, Drive, TorqueKind
from oed.experiment.recording import LEAST_TRAVEL, Recording, Role
from oed.experiment.temperature import missing_notes
from oed.robot import Robot

if TYPE_CHECKING:
    from pandas import DataFrame

    from oed.experiment.from_arrays import About, Arrays
    from oed.experiment.log_format import LogFormat


@dataclass(frozen=True)
class DataSet:
    """One robot and what was recorded of it.

    Attributes:
        name: Shown in reports.
        source: Where the data come from.
        licence: Of the data.
        robot: Its joints are the recordings' columns, its limits those of the data set.
        torque: How the torque was obtained: "measured" at the joint, from the drive's
            "current", or only "commanded".
        drive: What is known of the drives.
        recordings: In the order of the data set.

    Raises:
        ValueError: If a recording's number of joints is not the robot's, or a name is used twice.
    """

    name: str
    source: str
    licence: str
    robot: Robot
    torque: TorqueKind
    drive: Drive = field(default_factory=Drive)
    recordings: tuple[Recording, ...] = ()

    def __post_init__(self) -> None:
        if self.torque not in TORQUE_KINDS:
            raise ValueError(f"torque {self.torque!r} is none of {TORQUE_KINDS}")
        for recording in self.recordings:
            if recording.n != self.robot.n:
                raise ValueError(
                    f"recording {recording.name!r} has {recording.n} joints, "
                    f"robot {self.robot.name!r} has {self.robot.n}"
                )
        for key in DRIVE_KEYS:
            values = getattr(self.drive, key)
            if values is not None and len(values) != self.robot.n:
                raise ValueError(f"{key} of {len(values)} joints, the robot has {self.robot.n}")
        names = [recording.name for recording in self.recordings]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"recordings named twice: {twice}")

    @classmethod
    def from_arrays(
        cls,
        robot: Robot,
        *,
        t: Arrays,
        q: Arrays,
        tau: Arrays,
        dq: Arrays | None = None,
        ddq: Arrays | None = None,
        roles: Sequence[Role] | None = None,
        name: str = "arrays",
        torque: TorqueKind = "measured",
        drive: Drive | None = None,
    ) -> DataSet:
        """A data set of arrays at hand, with the checks that a file goes through.

        Args:
            robot: With n joints, in the order of the columns.
            t: (N,) time [s]; of several recordings a list of such arrays, and so for the others.
            q: (N, n) positions [rad or m].
            tau: (N, n) torques [N m or N], or currents [A] if the drive has `current_to_torque`.
            dq: (N, n) velocities [rad/s or m/s].
            ddq: (N, n) accelerations [rad/s^2 or m/s^2].
            roles: One a recording; if None they are proposed from pauses, repetitions and
                lengths, one recording is divided, and a note says how.
            name: Shown in reports.
            torque: How it was obtained.
            drive: What is known of the drives.

        Raises:
            ValueError: If shapes or numbers of recordings disagree.
            DataSetError: If the numbers cannot be what they should be, such as degrees.
        """
        from oed.experiment.from_arrays import About, recordings_from_arrays  # noqa: PLC0415  # loads pandas

        given = {"t": t, "q": q, "tau": tau, "dq": dq, "ddq": ddq}
        about = About(name, torque, drive or Drive())
        return cls._in_memory(robot, recordings_from_arrays(robot, given, roles, about), about)

    @classmethod
    def from_frame(
        cls,
        robot: Robot,
        frame: DataFrame | Sequence[DataFrame],
        *,
        roles: Sequence[Role] | None = None,
        log_format: LogFormat | None = None,
        name: str = "frame",
        torque: TorqueKind | None = None,
        drive: Drive | None = None,
    ) -> DataSet:
        """A data set of pandas frames, one a recording.

        Args:
            robot: With n joints.
            frame: Columns as in a log: `t`, `q_1` or `q_shoulder`, `tau_1`, or names that
                loggers use; an index with a name counts as a column.
            roles: As of `from_arrays`.
            log_format: Names of columns, units, signs and rate, if they are not as usual and SI.
            name: Shown in reports.
            torque: How the torque was obtained; by its columns' names if None.
            drive: What is known of the drives.

        Raises:
            ValueError: If there is no frame, or no time.
            DataSetError: If columns are missing or cannot be what they should be.
        """
        from oed.experiment.from_arrays import About, recordings_from_frame  # noqa: PLC0415  # loads pandas

        drive = drive or Drive()
        kind, recordings = recordings_from_frame(
            robot,
            frame,
            roles=roles,
            log_format=log_format,
            name=name,
            torque=torque,
            drive=drive,
        )
        return cls._in_memory(robot, recordings, About(name, kind, drive))

    @classmethod
    def _in_memory(cls, robot: Robot, recordings: tuple[Recording, ...], about: About) -> DataSet:
        return cls(
            name=about.name,
            source="arrays in memory",
            licence="not stated",
            robot=robot,
            torque=about.torque,
            drive=about.drive,
            recordings=recordings,
        )

    @property
    def torque_units(self) -> tuple[str, ...]:
        """(n,) unit of what stands for each joint's torque."""
        return tuple(joint.unit("N m") for joint in self.robot.joints)

    @property
    def torque_unit(self) -> str:
        """Of what stands for torque, for a column of a table, such as "N m or N"."""
        return " or ".join(dict.fromkeys(self.torque_units))

    @property
    def estimation(self) -> tuple[Recording, ...]:
        """Recordings to estimate parameters from."""
        return self._with_role("estimation")

    @property
    def validation(self) -> tuple[Recording, ...]:
        """Recordings to choose between models with."""
        return self._with_role("validation")

    @property
    def test(self) -> tuple[Recording, ...]:
        """Recordings to be looked at last."""
        return self._with_role("test")

    @property
    def unused(self) -> tuple[tuple[str, str], ...]:
        """Pairs (file, column) of the columns that nothing reads, to be shown to the user."""
        return tuple((r.source, column) for r in self.recordings for column in r.unused_columns)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is doubtful about the robot's file and the recordings' numbers, for the user."""
        of_each = tuple(note for recording in self.recordings for note in recording.notes)
        return self.robot.notes + of_each + missing_notes(self.recordings)

    def _with_role(self, role: Role) -> tuple[Recording, ...]:
        return tuple(recording for recording in self.recordings if recording.role == role)

    @property
    def still(self) -> dict[str, float]:
        """Travel [rad or m] of each joint that stands still in all estimation recordings."""
        return self.still_in("estimation")

    def still_in(self, role: Role) -> dict[str, float]:
        """Travel [rad or m] of each joint that stands still in all recordings of a role, of which there are some."""
        travels = np.max([np.ptp(r.q, axis=0) for r in self._with_role(role)], axis=0)
        names = self.robot.joint_names
        return {names[j]: float(travels[j]) for j in np.flatnonzero(travels < LEAST_TRAVEL)}

    def check_moves(self) -> None:
        """Refuse a joint that stands still in all recordings for estimation.

        Raises:
            OedError: If there is one: its friction and its row would be made of noise.
        """
        for joint, travel in self.still.items():
            raise OedError(
                f"{self.name}: joint {joint!r} moves by no more than {travel:.2g} rad or m "
                "in the estimation recordings, which tells nothing of its friction; record it "
                "moving, or leave it out of `joints` and say in [fixed] of dataset.toml where "
                "it stood"
            )
