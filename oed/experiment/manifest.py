"""`dataset.toml`: what a data set says of itself, checked key by key."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from jaxtyping import Float
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.dataset import DRIVE_KEYS, TORQUE_KINDS, Drive, TorqueKind
from oed.experiment.recording import ROLES, Role
from oed.experiment.toml_table import LARGEST, TomlTable

MANIFEST = "dataset.toml"
FORMAT = 1
LIMIT_KEYS = ("position", "velocity", "acceleration", "torque", "jerk")
TOP_KEYS = (
    "format",
    "name",
    "source",
    "licence",
    "robot",
    "joints",
    "gravity",
    "torque",
)
RECORDING_KEYS = ("file", "role", "repetitions", "period")
SUFFIXES = (".csv", ".parquet")


@dataclass(frozen=True)
class RecordingEntry:
    """One [[recording]] table: its file, role, repetitions and period [s]."""

    file: str
    role: Role
    repetitions: int | None
    period: float | None

    @property
    def name(self) -> str:
        """The file's path without its suffix."""
        return str(PurePosixPath(self.file).with_suffix(""))


@dataclass(frozen=True)
class Manifest:
    """The content of `dataset.toml`; limits are (n, 2), gravity (3,) [m/s^2]."""

    name: str
    source: str
    licence: str
    robot: str
    joints: tuple[str, ...]
    gravity: Float[ndarray, "3"]
    torque: TorqueKind
    limits: dict[str, Float[ndarray, "joints 2"]]
    drive: Drive
    recordings: tuple[RecordingEntry, ...]


def read_manifest(directory: Path) -> Manifest:
    """Read and check `dataset.toml` of a folder.

    Raises:
        DataSetError: At the first thing in it that the format does not allow.
    """
    path = directory / MANIFEST
    table = TomlTable(_parse(path), path)
    table.only(*TOP_KEYS, "limits", "drive", "recording")
    if table.integer("format") != FORMAT:
        table.fail("format", f"another version; this reader knows format = {FORMAT}")
    joints = table.names("joints")
    return Manifest(
        name=table.text("name"),
        source=table.text("source"),
        licence=table.text("licence"),
        robot=table.text("robot"),
        joints=joints,
        gravity=table.numbers("gravity", 3),
        torque=table.one_of("torque", TORQUE_KINDS),
        limits=_limits(table.child("limits"), len(joints)),
        drive=_drive(table.child("drive"), len(joints)),
        recordings=_recordings(table),
    )


def _parse(path: Path) -> dict[str, object]:
    if not path.is_file():
        raise DataSetError(
            f"missing; a data set is a folder that holds a {MANIFEST}", file=str(path)
        )
    try:
        text = path.read_bytes().decode("utf-8-sig")
        return tomllib.loads(text)
    except OSError as error:
        raise DataSetError(f"cannot be read: {error.strerror}", file=str(path)) from error
    except UnicodeDecodeError as error:
        row = path.read_bytes()[: error.start].count(b"\n") + 1
        raise DataSetError(
            "is not UTF-8 text; save it as UTF-8", file=str(path), row=row
        ) from error
    except (ValueError, RecursionError) as error:
        line = re.search(r"at line (\d+)", str(error))
        row = int(line[1]) if line else None
        raise DataSetError(f"is not TOML: {error}", file=str(path), row=row) from error


def _limits(table: TomlTable, n: int) -> dict[str, Float[ndarray, "joints 2"]]:
    table.only(*LIMIT_KEYS)
    return {key: table.bounds(key, n) for key in LIMIT_KEYS if table.has(key)}


def _drive(table: TomlTable, n: int) -> Drive:
    table.only(*DRIVE_KEYS)
    given = {key: table.numbers(key, n) for key in DRIVE_KEYS if table.has(key)}
    for key, values in given.items():
        if key == "rotor_inertia" and (values < 0).any():
            table.fail(key, f"must not be negative, got {values.tolist()}")
        if key != "rotor_inertia" and (values == 0).any():
            table.fail(key, f"must not be zero, got {values.tolist()}")
    return Drive(**given)


def _recordings(table: TomlTable) -> tuple[RecordingEntry, ...]:
    entries: list[RecordingEntry] = []
    for child in table.children("recording"):
        entry = _recording(child)
        for earlier in entries:
            if PurePosixPath(earlier.file) == PurePosixPath(entry.file):
                child.fail("file", f"{entry.file!r} is listed twice; list each recording once")
            if earlier.name == entry.name:
                child.fail("file", f"{entry.file!r} and {earlier.file!r} differ in suffix only")
        entries.append(entry)
    return tuple(entries)


def _recording(table: TomlTable) -> RecordingEntry:
    table.only(*RECORDING_KEYS)
    file = table.text("file")
    if PurePosixPath(file).suffix.lower() not in SUFFIXES:
        table.fail("file", f"{file!r} must end in one of {SUFFIXES}")
    repetitions = table.integer("repetitions") if table.has("repetitions") else None
    if repetitions is not None and not 1 <= repetitions <= LARGEST:
        table.fail("repetitions", f"must be at least 1 and below {LARGEST:g}")
    period = table.number("period") if table.has("period") else None
    if period is not None and not 0 < period <= LARGEST:
        table.fail("period", f"must be a positive number of seconds, got {period:g}")
    return RecordingEntry(file, table.one_of("role", ROLES), repetitions, period)
