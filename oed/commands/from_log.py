"""A log in place of a data set: with --robot, any command that starts from data imports it first."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

from oed.commands.configurations import DataCommand, DataSetCommand
from oed.commands.telling import say
from oed.experiment.dataset import DataSet
from oed.experiment.importing.import_log import Import, ImportChoices, propose_import
from oed.experiment.importing.write_import import place_import
from oed.experiment.manifest import MANIFEST
from oed.report.study_files import IMPORT

FOLDER = "data"  # within a command's own: the data set that is made of a log
ConfigT = TypeVar("ConfigT", bound=DataCommand)


def on_data_set(config: ConfigT, out: Path) -> ConfigT:
    """The command as it is given the data set that is made of its log, or was given at once."""
    if config.robot is None:
        return config
    return dataclasses.replace(config, data=out / FOLDER, robot=None)


def imported(config: ConfigT, out: Path) -> ConfigT:
    """The same, once the data set is there; it says what was concluded about the log.

    Args:
        config: Whose log is read, where it was given one.
        out: Folder for results, in which the data set stays: it can be corrected and used again.

    Raises:
        DataSetError: If the log cannot be read, or something about it cannot be concluded.
        ValueError: If there is no log, or the data set was corrected since it was made.
    """
    folder, robot = out / FOLDER, _robot_of_log(config)
    if robot is None:
        return config
    log = config.data
    with IMPORT.in_folder(folder, [log, robot]) as results:
        if changed := results.changed():
            raise ValueError(
                f"{folder / changed[0]} was changed since it was imported: give {folder} in place "
                "of the log, without --robot"
            )
        found = _propose(log, robot, folder)
        with results.replaced() as new:
            place_import(found, new, folder)
    return on_data_set(config, out)


def read_or_imported(config: DataSetCommand) -> DataSet | Path:
    """What a command that leaves no folder starts from: a data set's folder, or what its log says.

    Raises:
        DataSetError: As `imported`.
        ValueError: If there is no log.
    """
    robot = _robot_of_log(config)
    if robot is None:
        return config.data
    return _propose(config.data, robot, Path(), config.joints).dataset


def _robot_of_log(config: DataCommand) -> str | None:
    """The robot's file, where the command was given a log and not a data set."""
    log = config.data
    if config.robot is None:
        if log.is_file():
            raise ValueError(f"{log}: is a file, no data set; of a log, --robot names the robot")
        return None
    if not log.exists():
        raise ValueError(f"{log}: no such log")
    if (log / MANIFEST).exists():
        raise ValueError(f"--robot: {log} is a data set, which names its robot; leave it out")
    return config.robot


def _propose(log: Path, robot: str, folder: Path, joints: Sequence[str] = ()) -> Import:
    say(f"importing {log}")
    found = propose_import([log], ImportChoices(robot, name=log.stem), folder, joints=joints)
    for note in found.notes:
        say(f"  {note}")
    return found
