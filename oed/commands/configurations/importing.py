"""The command that makes a data set of logs: oed import."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from oed.commands.configurations.command import Command
from oed.commands.options import Gravity, OutFolder, Range, Rate, Real


@dataclass(frozen=True, kw_only=True)
class ImportLog(Command):
    """Make a data set of log files: ROS 2 bags, CSV, Parquet, .mat, .npz, HDF5.

    Finds columns, joints, units and roles, says why, and writes a folder with a dataset.toml that
    can be read, corrected and kept. Nothing is written if anything cannot be used.

    Attributes:
        logs: Log files of one format, in the order in which they were recorded.
        robot: The robot's file, or builtin:NAME.
        out: Folder to make.
        joints: The robot's joints in the order of the log's columns.
        columns: Columns, as in t=time q=a,b tau=c,d; dq= leaves velocities out.
        units: Units, as in q=deg tau=mNm t=ms.
        sign: 1 or -1 a joint, where the log counts the other way.
        zero: Logged position of each joint where the robot's joint is at zero, in the log's unit.
        ticks_per_turn: Encoder ticks a turn, where positions are in ticks.
        rate: Rows a second, where no column tells the time [Hz].
        fixed: Position [rad or m] of each joint that stood still and is not logged, as in finger=0.04.
        torque: How the torque was obtained.
        current_to_torque: Joint torque per motor current, gear included, one a joint [N m/A].
        gravity: In the robot's base frame [m/s^2].
        roles: Role of each log: estimation, validation or test; concluded if not given.
        reference: Leave logs where they are instead of copying them.
    """

    logs: Annotated[tuple[Path, ...], tyro.conf.Positional]
    robot: str
    out: OutFolder
    joints: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    sign: tuple[Real, ...] = ()
    zero: tuple[Real, ...] = ()
    ticks_per_turn: Annotated[float, Range(1.0)] | None = None
    rate: Rate | None = None
    fixed: tuple[str, ...] = ()
    torque: Literal["measured", "current", "commanded"] | None = None
    current_to_torque: tuple[Real, ...] = ()
    gravity: tuple[Gravity, Gravity, Gravity] = (0.0, 0.0, -9.81)
    roles: tuple[Literal["estimation", "validation", "test"], ...] = ()
    reference: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.logs:
            raise ValueError("name at least one log file")
