"""What is in this log? A data set that all other commands read.

    python -m studies.import_log LOG … --robot arm.urdf --out mydata/

Reads ROS 2 bags (SQLite, MCAP), CSV of any dialect, Parquet, .mat, .npz and HDF5, finds columns,
joints, units and roles, says why, checks the recordings, and writes a folder with a dataset.toml
that can be read, corrected and kept. Nothing is written if anything cannot be used.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from oed.commands.options import parse
from oed.errors import OedError
from oed.experiment.dataset import TorqueKind
from oed.experiment.importing.import_log import ImportChoices, propose_import, write_import
from oed.experiment.importing.stated import stated_numbers, stated_words
from oed.experiment.recording import Role
from studies.interrupt import leave


@dataclass(frozen=True)
class Config:
    """Make a data set of log files.

    Attributes:
        logs: Log files of one format, in the order in which they were recorded.
        robot: The robot's file, or builtin:NAME.
        out: Folder to make.
        joints: The robot's joints in the order of the log's columns.
        columns: Columns, as in t=time q=a,b tau=c,d; dq= leaves velocities out.
        units: Units, as in q=deg tau=mNm t=ms.
        sign: 1 or -1 a joint, where the log counts the other way.
        zero: What is logged where each joint of the robot is at zero.
        ticks_per_turn: Of encoders that are logged in ticks.
        rate: Rows a second, where no column tells the time [Hz].
        fixed: Where joints stood that are not logged [rad or m], as in finger=0.04.
        torque: How the torque was obtained.
        current_to_torque: Joint torque per motor current, one a joint [N m/A].
        gravity: In the robot's base frame [m/s^2].
        roles: One a log.
        reference: Leave logs where they are instead of copying them.
    """

    logs: Annotated[tuple[Path, ...], tyro.conf.Positional]
    robot: str
    out: Path
    joints: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    sign: tuple[float, ...] = ()
    zero: tuple[float, ...] = ()
    ticks_per_turn: float | None = None
    rate: float | None = None
    fixed: tuple[str, ...] = ()
    torque: TorqueKind | None = None
    current_to_torque: tuple[float, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    roles: tuple[Role, ...] = ()
    reference: bool = False


def run(config: Config) -> tuple[str, ...]:
    """Read, conclude, check, write; returns what was concluded."""
    choices = ImportChoices(
        robot=config.robot,
        joints=config.joints,
        columns=stated_words("--columns", config.columns),
        units=stated_words("--units", config.units),
        sign=config.sign,
        zero=config.zero,
        ticks_per_turn=config.ticks_per_turn,
        rate=config.rate,
        fixed=stated_numbers("--fixed", config.fixed),
        torque=config.torque,
        current_to_torque=config.current_to_torque,
        gravity=config.gravity,
        roles=config.roles,
    )
    found = propose_import(config.logs, choices, config.out)
    write_import(found, config.out, reference=config.reference)
    return found.notes


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all went well, 2 if the input cannot be used."""
    config = parse(Config, prog="python -m studies.import_log", arguments=arguments)
    try:
        notes = run(config)
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"studies.import_log: {error}\n")
        return 2
    for note in notes:
        sys.stdout.write(f"  {note}\n")
    sys.stdout.write(f"wrote {config.out}; read dataset.toml there and correct what is wrong\n")
    return 0


if __name__ == "__main__":
    leave(main, "studies.import_log")
