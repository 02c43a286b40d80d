"""What is read from a path that a user gave: a regular file, no larger than its kind can be.

A pipe without a writer, a device that never ends, or a file of another kind under the wrong name
would otherwise hold a command up, or fill the memory, before anything can be said about it.
"""

from __future__ import annotations

import json
import math
import os
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Never

from oed.errors import OedError

MEGABYTE = 1_000_000


@dataclass(frozen=True)
class SizeLimit:
    """How large a file of one kind may be.

    Attributes:
        most: Largest size [bytes].
        why: What is known of files of that kind, for the message.
    """

    most: int
    why: str


ROBOT_FILE = SizeLimit(
    64 * MEGABYTE, "a robot without its meshes is described in less than a few megabytes"
)
MANIFEST_FILE = SizeLimit(
    4 * MEGABYTE, "a description of a thousand recordings takes less than a megabyte"
)
JSON_FILE = SizeLimit(64 * MEGABYTE, "the records that this program writes have a few megabytes")
RECORDING_FILE = SizeLimit(
    2000 * MEGABYTE, "a recording is read into memory whole, and takes several times its size there"
)
# In one data set. Each recording is filtered, kept and drawn on its own.
MOST_RECORDINGS = 1000
# In one file. Seven joints with position, velocity, acceleration, torque and temperature have 36.
MOST_COLUMNS = 10_000
# Rows times columns that are used, 8 bytes each: seven million samples of seven joints.
MOST_NUMBERS = 200_000_000
KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISDIR, "a folder"),
)


class UnreadableFile(OedError):
    """A file that cannot be read as what it should be.

    Attributes:
        path: The file.
        reason: What is wrong, without the name of the file.
    """

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path}: {reason}")
        self.path = path
        self.reason = reason


def read_file(path: str | Path, limit: SizeLimit) -> bytes:
    """The content of a regular file.

    Raises:
        FileNotFoundError: If there is none.
        UnreadableFile: If it is a folder, pipe, device or socket, is larger than `limit`, or
            cannot be opened.
    """
    path = Path(path)
    try:
        # Without O_NONBLOCK, a pipe that nobody writes to would never open.
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UnreadableFile(path, f"cannot be read: {reason}") from error
    try:
        _check_state(path, os.fstat(handle), limit)
        with os.fdopen(handle, "rb", closefd=False) as file:
            content = file.read(limit.most + 1)
    except OSError as error:
        raise UnreadableFile(path, f"cannot be read: {error.strerror}") from error
    finally:
        os.close(handle)
    if len(content) > limit.most:
        raise UnreadableFile(path, _too_large(len(content), limit))
    return content


def check_file(path: str | Path, limit: SizeLimit) -> None:
    """Refuse what is no regular file, or a larger one than `limit`, before a library opens it.

    Raises:
        FileNotFoundError: If there is none.
        UnreadableFile: As of `read_file`.
    """
    path = Path(path)
    try:
        state = path.stat()
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UnreadableFile(path, f"cannot be read: {reason}") from error
    _check_state(path, state, limit)


def too_many_numbers(count: int) -> str:
    """Why so many numbers are not read into memory; empty where they may be."""
    if count <= MOST_NUMBERS:
        return ""
    return (
        f"holds {count} numbers in the columns that are asked for, more than {MOST_NUMBERS}, which "
        "take 1.6 GB; cut the log"
    )


def read_json(path: str | Path, limit: SizeLimit = JSON_FILE) -> object:
    """The value in a JSON file, whose numbers are all finite.

    Raises:
        FileNotFoundError: If there is no such file.
        UnreadableFile: If it cannot be read, is not UTF-8 text, not JSON, nested too deeply, or
            holds a number that is not finite.
    """
    path = Path(path)
    content = read_file(path, limit)
    try:
        return json.loads(content.decode("utf-8-sig"), parse_constant=_refuse, parse_float=_finite)
    except UnicodeDecodeError as error:
        raise UnreadableFile(path, "not JSON: it is not UTF-8 text") from error
    except RecursionError as error:
        raise UnreadableFile(path, "not JSON of ours: it is nested too deeply") from error
    except ValueError as error:
        raise UnreadableFile(path, f"not JSON: {error}") from error


def _check_state(path: Path, state: os.stat_result, limit: SizeLimit) -> None:
    for is_kind, name in KINDS:
        if is_kind(state.st_mode):
            raise UnreadableFile(path, f"is {name}, not a file")
    if state.st_size > limit.most:
        raise UnreadableFile(path, _too_large(state.st_size, limit))


def _too_large(size: int, limit: SizeLimit) -> str:
    return (
        f"is larger than {limit.most // MEGABYTE} MB"
        f"{f' ({size / MEGABYTE:.0f} MB)' if size > limit.most + 1 else ''}: {limit.why}"
    )


def _refuse(constant: str) -> Never:
    raise ValueError(f"{constant} is not a number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:40]} is too large")
    return value
