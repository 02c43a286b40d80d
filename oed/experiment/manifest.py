"""`dataset.toml`: what a data set says of itself, checked key by key."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.drive import DRIVE_KEYS, TORQUE_KINDS, Drive, TorqueKind
from oed.experiment.log_format import FORMAT_KEYS, LogFormat, read_log_format
from oed.experiment.recording import ROLES, Role
from oed.experiment.toml_table import TomlTable, nearest
from oed.input_file import MANIFEST_FILE, MOST_RECORDINGS, UnreadableFile, read_file
from oed.largest_number import LARGEST, MOST_GRAVITY

MANIFEST = "dataset.toml"
FORMAT = 1
COMBINATION = "combination"
LIMIT_KEYS = ("position", "velocity", "acceleration", "torque", "jerk")
TOP_KEYS = (
    "format",
    "name",
    "source",
    "licence",
    "robot",
    "robot_from",
    "joints",
    "gravity",
    "torque",
)
RECORDING_KEYS = ("file", "name", "role", "repetitions", "period", "rows", "from", "to")


@dataclass(frozen=True)
class RecordingEntry:
    """One [[recording]] table.

    Attributes:
        file: The log, relative to the folder.
        name: Of the recording.
        role: What it may be used for.
        repetitions: Whole periods of one motion that it holds.
        period: Of that motion [s].
        rows: First and last row of the log that belong to it, counted from 1; all if None.
        span: From when to before when rows belong to it, since the log's first row [s].
    """

    file: str
    name: str
    role: Role
    repetitions: int | None = None
    period: float | None = None
    rows: tuple[int, int] | None = None
    span: tuple[float, float] | None = None

    def overlaps(self, other: RecordingEntry) -> bool:
        """Whether rows of one log may be in both, as far as the entries tell."""
        if self.rows and other.rows:
            return self.rows[0] <= other.rows[1] and other.rows[0] <= self.rows[1]
        if self.span and other.span:
            return self.span[0] < other.span[1] and other.span[0] < self.span[1]
        return True


@dataclass(frozen=True)
class SumEntry:
    """One [[limits.combination]] table.

    Attributes:
        factors: By name of the joint.
        bounds: Lower and upper of the sum of positions [rad or m].
    """

    factors: dict[str, float]
    bounds: tuple[float, float]


@dataclass(frozen=True)
class Manifest:
    """The content of `dataset.toml`.

    Limits are (n, 2), gravity (3,) [m/s^2], `fixed` the positions [rad or m] of joints that stood
    still and are no columns, by name. `robot_from` is the file that `robot` is a copy of, relative to
    the folder; empty where it lies in its own surroundings. There are no recordings before the first experiment.
    """

    name: str
    source: str
    licence: str
    robot: str
    robot_from: str
    joints: tuple[str, ...]
    gravity: Float[ndarray, "3"]
    torque: TorqueKind
    limits: dict[str, Float[ndarray, "joints 2"]]
    sums: tuple[SumEntry, ...]
    drive: Drive
    log: LogFormat
    fixed: dict[str, float]
    recordings: tuple[RecordingEntry, ...]


def read_manifest(directory: Path) -> Manifest:
    """Read and check `dataset.toml` of a folder.

    Raises:
        DataSetError: At the first thing in it that the format does not allow.
    """
    path = directory / MANIFEST
    return manifest_of(TomlTable(_parse(path), path))


def manifest_of(table: TomlTable) -> Manifest:
    """Check the content of a `dataset.toml`.

    Raises:
        DataSetError: At the first thing in it that the format does not allow.
    """
    table.only(*TOP_KEYS, *FORMAT_KEYS, "limits", "drive", "fixed", "recording")
    if table.integer("format") != FORMAT:
        table.fail("format", f"another version; this reader knows format = {FORMAT}")
    joints = table.names("joints")
    return Manifest(
        name=table.text("name"),
        source=table.text("source"),
        licence=table.text("licence"),
        robot=table.text("robot"),
        robot_from=table.text("robot_from") if table.has("robot_from") else "",
        joints=joints,
        gravity=_gravity(table),
        torque=table.one_of("torque", TORQUE_KINDS),
        limits=_limits(table.child("limits"), len(joints)),
        sums=_sums(table.child("limits"), joints),
        drive=_drive(table.child("drive"), len(joints)),
        log=read_log_format(table, len(joints)),
        fixed=_fixed(table.child("fixed"), joints),
        recordings=_recordings(table),
    )


def _gravity(table: TomlTable) -> Float[ndarray, "3"]:
    gravity = table.numbers("gravity", 3)
    if (most := np.abs(gravity).max()) > MOST_GRAVITY:
        on_planets = f"no planet has more than {MOST_GRAVITY:g}"
        raise table.error("gravity", f"{most:g} m/s^2, but {on_planets}: state it in m/s^2")
    return gravity


def _parse(path: Path) -> dict[str, object]:
    try:
        content = read_file(path, MANIFEST_FILE)
    except FileNotFoundError:
        raise DataSetError(
            f"missing; a data set is a folder that holds a {MANIFEST}", file=str(path)
        ) from None
    except UnreadableFile as error:
        raise DataSetError(error.reason, file=str(path)) from error
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        row = content[: error.start].count(b"\n") + 1
        raise DataSetError(
            "is not UTF-8 text; save it as UTF-8", file=str(path), row=row
        ) from error
    except (ValueError, RecursionError) as error:
        line = re.search(r"at line (\d+)", str(error))
        row = int(line[1]) if line else None
        raise DataSetError(f"is not TOML: {error}", file=str(path), row=row) from error


def _limits(table: TomlTable, n: int) -> dict[str, Float[ndarray, "joints 2"]]:
    table.only(*LIMIT_KEYS, COMBINATION)
    return {key: table.bounds(key, n) for key in LIMIT_KEYS if table.has(key)}


def _sums(table: TomlTable, joints: tuple[str, ...]) -> tuple[SumEntry, ...]:
    if not table.has(COMBINATION):
        return ()
    return tuple(_sum(child, joints) for child in table.children(COMBINATION))


def _sum(table: TomlTable, joints: tuple[str, ...]) -> SumEntry:
    table.only("joints", "factors", "position")
    names = table.names("joints")
    for name in names:
        if name not in joints:
            table.fail("joints", f"no joint {name!r} in `joints`; {nearest(name, joints)}")
    factors = table.numbers("factors", len(names)) if table.has("factors") else np.ones(len(names))
    if not factors.any():
        table.fail("factors", "are all zero, so nothing is bounded")
    return SumEntry(dict(zip(names, factors.tolist(), strict=True)), table.bound("position"))


def _drive(table: TomlTable, n: int) -> Drive:
    table.only(*DRIVE_KEYS)
    given = {key: table.numbers(key, n) for key in DRIVE_KEYS if table.has(key)}
    for key, values in given.items():
        if key == "rotor_inertia" and (values < 0).any():
            table.fail(key, f"must not be negative, got {values.tolist()}")
        if key != "rotor_inertia" and (values == 0).any():
            table.fail(key, f"must not be zero, got {values.tolist()}")
    return Drive(**given)


def _fixed(table: TomlTable, joints: tuple[str, ...]) -> dict[str, float]:
    for name in table.keys:
        if name in joints:
            table.fail(name, "is in `joints` too; a joint is recorded, or fixed")
    return {name: table.number(name) for name in table.keys}


def _recordings(table: TomlTable) -> tuple[RecordingEntry, ...]:
    # None yet is the normal state before the first experiment; who needs some says so.
    if not table.has("recording") or table.value("recording") == []:
        return ()
    children = table.children("recording")
    if len(children) > MOST_RECORDINGS:
        table.fail(
            "recording",
            f"lists {len(children)} recordings, more than {MOST_RECORDINGS}, each of which would "
            "be filtered and kept on its own; join those that follow one another, or choose some",
        )
    files = [child.text("file") for child in children]
    entries: list[RecordingEntry] = []
    for child in children:
        entry = _recording(child, is_alone=files.count(child.text("file")) == 1)
        for earlier in entries:
            _check_pair(child, earlier, entry)
        entries.append(entry)
    return tuple(entries)


def _check_pair(child: TomlTable, earlier: RecordingEntry, entry: RecordingEntry) -> None:
    is_same = PurePosixPath(earlier.file) == PurePosixPath(entry.file)
    if is_same and earlier.overlaps(entry):
        message = (
            f"{entry.file!r} is listed twice; list each recording once, or cut the log by `rows`, "
            "or `from` and `to`, that do not overlap"
        )
        child.fail("file", message)
    if earlier.name == entry.name:
        if is_same or child.has("name"):
            child.fail("name", f"{entry.name!r} is the name of two recordings; give each its own")
        message = f"{entry.file!r} and {earlier.file!r} differ in suffix only; give one a `name`"
        child.fail("file", message)


def _recording(table: TomlTable, *, is_alone: bool) -> RecordingEntry:
    table.only(*RECORDING_KEYS)
    file = table.text("file")
    role = table.one_of("role", ROLES)
    repetitions = table.integer("repetitions") if table.has("repetitions") else None
    if repetitions is not None and not 1 <= repetitions <= LARGEST:
        table.fail("repetitions", f"must be at least 1 and below {LARGEST:g}")
    period = table.number("period") if table.has("period") else None
    if period is not None and not 0 < period <= LARGEST:
        table.fail("period", f"must be a positive number of seconds, got {period:g}")
    stem = str(PurePosixPath(file).with_suffix("")) if PurePosixPath(file).name else file
    return RecordingEntry(
        file,
        table.text("name") if table.has("name") else stem if is_alone else f"{stem}-{role}",
        role,
        repetitions,
        period,
        _rows(table),
        _span(table),
    )


def _rows(table: TomlTable) -> tuple[int, int] | None:
    if not table.has("rows"):
        return None
    if table.has("from") or table.has("to"):
        table.fail("rows", "stands beside `from` or `to`; cut by rows or by time")
    first, last = table.numbers("rows", 2)
    if first != round(first) or last != round(last) or not 1 <= first < last:
        table.fail(
            "rows", f"must be [first, last], counted from 1, got {table.value('rows')!r:.60}"
        )
    return int(first), int(last)


def _span(table: TomlTable) -> tuple[float, float] | None:
    if not (table.has("from") or table.has("to")):
        return None
    start = table.number("from") if table.has("from") else 0.0
    end = table.number("to") if table.has("to") else float("inf")
    if not 0 <= start < end:
        table.fail(
            "from" if table.has("from") else "to", f"cuts from {start:g} s to {end:g} s: nothing"
        )
    return start, end
