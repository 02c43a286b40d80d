"""A public recording: whose it is, how its logs are read, which rows are sealed, what was published."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.experiment.importing.write_import import write_import
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Role

Torque = Callable[[Motion], Float[ndarray, "samples joints"]]


@dataclass(frozen=True)
class Peer:
    """The model that was published with a recording.

    Attributes:
        model: Whose it is, and what it has.
        fitted: On which data its authors say that it was fitted.
        torque: Makes it of a clone and of a folder for what is made of it; None where the clone
            has nothing that runs.
        why_not: Why it has nothing that runs.
    """

    model: str
    fitted: str
    torque: Callable[[Path, Path], Torque] | None = None
    why_not: str = ""


@dataclass(frozen=True)
class Log:
    """A log file, and what its rows may be used for.

    Attributes:
        path: The file.
        role: None where one log is divided by time into 60, 20 and 20 %, as `oed import` does.
    """

    path: Path
    role: Role | None = None


@dataclass(frozen=True)
class PublicArm:
    """A recording that anyone can fetch.

    Attributes:
        name: In tables.
        repository: On GitHub.
        commit: At which it was read last.
        licence: Of the data.
        marker: A file by which a clone of the repository is known.
        choices: What is said of its logs, by the clone and a folder for files that are made of it.
        logs: Its log files, by the same; made where the clone's own need joining.
        protocol: Which rows are fitted, validated and sealed, in words.
        flatters: What the protocol flatters; empty where the sealed rows are of another motion.
        peer: What was published with it.
    """

    name: str
    repository: str
    commit: str
    licence: str
    marker: str
    choices: Callable[[Path, Path], ImportChoices]
    logs: Callable[[Path, Path], tuple[Log, ...]]
    protocol: str
    flatters: str
    peer: Peer

    @property
    def fetch(self) -> str:
        """The command that fetches it."""
        return f"git clone https://github.com/{self.repository}"

    def imported(self, clone: Path, folder: Path) -> DataSet:
        """The data set of a clone, as `oed import` makes it.

        Args:
            clone: Of the repository.
            folder: New or empty; `data` in it is the data set, beside what was made for it.
        """
        folder.mkdir(parents=True, exist_ok=True)
        logs = self.logs(clone, folder)
        roles = tuple(log.role for log in logs if log.role is not None)
        choices = replace(self.choices(clone, folder), roles=roles)
        found = propose_import([log.path for log in logs], choices, folder / "data")
        write_import(found, folder / "data")
        return read_dataset(folder / "data")


ONE_MOTION = (
    "One motion cut in time: the sealed part has the same frequencies, the same temperature and the "
    "same day as the fitted one, so every model looks better than on another motion."
)
