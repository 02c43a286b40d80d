"""Which files an input is made of: those that a data set or a robot's file names as well."""

from __future__ import annotations

import hashlib
import os
import re
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from oed.experiment.manifest import MANIFEST
from oed.input_file import MANIFEST_FILE, UnreadableFile, read_file

LONGEST = 20_000_000  # [B] of a text that is searched for names of files
# What stands in quotes or between tags and ends like a file's name.
NAMED = re.compile(r"""["'>]\s*([^"'<>\n]{1,500}\.\w{1,8})\s*["'<]""")
SCHEME = re.compile(r"^\w+://")


def input_files(path: str | Path) -> tuple[Path, ...]:
    """The files behind an input that exists: itself, and what it names, in a fixed order.

    Args:
        path: A data set's folder, a robot's file, or any other file. One that does not exist,
            such as "builtin:imi_scara", has none.
    """
    path = Path(path)
    found: dict[Path, None] = {}
    _collect(path / MANIFEST if path.is_dir() else path, found)
    return tuple(found)


def data_digest(path: str | Path) -> str:
    """Hash of the content of an input's files: the same wherever they lie."""
    digest = hashlib.sha256()
    folder = Path(path) if Path(path).is_dir() else Path(path).parent
    for file in input_files(path):
        digest.update(f"{os.path.relpath(file, folder)}\0".encode())
        try:
            with file.open("rb") as stream:
                digest.update(hashlib.file_digest(stream, "sha256").digest())
        except OSError as error:
            digest.update(f"{error.strerror}\0".encode())
    return digest.hexdigest()


def check_apart(folder: Path, homes: Iterable[Path], inputs: Sequence[str | Path]) -> None:
    """Refuse a folder for results that holds what is read.

    Args:
        folder: For results.
        homes: It and each folder below that results go to.
        inputs: Data sets and files, as they were given.

    Raises:
        ValueError: Naming the input.
    """
    places = {_place(home) for home in homes}
    for given in inputs:
        if Path(given).is_dir() and _place(Path(given)) in places:
            raise ValueError(
                f"--out {folder}: is the folder that is read, {given}; choose another folder"
            )
        for file in input_files(given):
            if _place(file.parent) in places or _place(file.resolve().parent) in places:
                raise ValueError(
                    f"--out {folder}: holds {file.name}, which is read; choose another folder"
                )
        # A package's meshes are found by the simulator: here only their names are known.
        for home in homes:
            for name in _package_files(Path(given)):
                if (home / name).is_file():
                    raise ValueError(
                        f"--out {folder}: holds {name}, which {given} names; choose another folder"
                    )


def _collect(file: Path, found: dict[Path, None]) -> None:
    """Add a file, and those that it names, robots' meshes and what they include as well."""
    # Not `Path.is_file`, which raises where the text can be no path.
    if file in found or not os.path.isfile(file):  # noqa: PTH113
        return
    found[file] = None
    for name in _names(file):
        if not SCHEME.match(name):
            _collect(file.parent / name, found)


def _names(file: Path) -> Iterator[str]:
    """Names of files in a data set's manifest or a robot's file, as they stand there."""
    if file.name == MANIFEST:
        try:
            content = read_file(file, MANIFEST_FILE)
            yield from _texts(tomllib.loads(content.decode("utf-8-sig")))
        except (OSError, UnreadableFile, ValueError, RecursionError):
            return  # that it cannot be read is for its reader to say
    elif file.suffix.lower() in (".urdf", ".xml", ".sdf", ".mjcf", ".xacro"):
        try:
            if file.stat().st_size < LONGEST:
                yield from NAMED.findall(file.read_text(encoding="utf-8", errors="replace"))
        except OSError:
            return


def _package_files(path: Path) -> Iterator[str]:
    for file in input_files(path):
        yield from (name.rpartition("/")[2] for name in _names(file) if SCHEME.match(name))


def _texts(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, list):
        for item in value:
            yield from _texts(item)


def _place(folder: Path) -> tuple[int, int] | Path:
    """What two names of one folder share: a link, a mount or another spelling is no other place."""
    try:
        status = folder.stat()
    except OSError:
        return folder.absolute()
    return status.st_dev, status.st_ino
