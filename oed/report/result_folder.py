"""A run's results in the folder that `--out` names: all of them or none, and nothing lost.

    with ResultFiles("identify", names).in_folder(out, inputs=[data]) as results:  # before the work
        ...
        with results.replaced() as new:  # a folder to write to
            write(..., new)

Before the work, a folder is refused that cannot be written, holds what is read, holds results of
another command or files without the record of a run, or in which another run works. The results
are written within the folder, in a part of it that a listing does not show, and moved into their
places when they are whole. That survives a folder that is a mount of its own, and a run that is
killed at any moment: the next one finishes the move, or clears away what was half written. Only
what the record of an earlier run lists is ever replaced, and only as that run left it, by the hash
of its content.
"""

from __future__ import annotations

import errno
import hashlib
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from oed.experiment.manifest import MANIFEST
from oed.report.folder_lock import RECORD, STATE, held
from oed.report.input_files import check_apart
from oed.report.json_file import read_json, write_json
from oed.report.output_folder import check_output_folder, is_committed, is_scratch, of_others

NEW, READY = "new", "ready.json"
LISTED = 3  # names of files in a message
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
NO_FILE = "no file"  # in place of a hash, where a folder, a link or a device lies


@dataclass(frozen=True)
class Record:
    """What a run left.

    Attributes:
        command: That left it.
        key: Hash of what decides its results; empty where nobody asks.
        files: Hash of each, by its place in the folder.
    """

    command: str
    key: str
    files: dict[str, str]

    @classmethod
    def read(cls, path: Path) -> Record | None:
        """The record in a file; None where there is none that can be read."""
        try:
            told = read_json(path)
            files = {str(name): str(hashed) for name, hashed in told["files"].items()}
            if any(PurePosixPath(n).is_absolute() or ".." in PurePosixPath(n).parts for n in files):
                return None
            return cls(str(told["command"]), str(told["key"]), files)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return None


@dataclass(frozen=True)
class ResultFiles:
    """The files of a command.

    Attributes:
        command: Its name.
        names: Of all files that it may leave, relative to the folder, the one that says most
            first; empty where they depend on its input.
        goes_on: Whether a run leaves other files in the folder before it has a record there, from
            which the next goes on.
    """

    command: str
    names: tuple[str, ...] = ()
    goes_on: bool = False

    @contextmanager
    def in_folder(self, folder: Path, inputs: Sequence[str | Path] = ()) -> Iterator[ResultFolder]:
        """The folder for one run, which no other enters until the block ends.

        Args:
            folder: That `--out` names.
            inputs: Data sets and files that are read, as they were given; not what is built in.

        Raises:
            ValueError: In one line, if results cannot or must not go there.
        """
        check_output_folder(folder)
        folder = folder.resolve()
        below = {folder / name for name in self.names}
        check_apart(folder, {folder, folder / STATE, *(file.parent for file in below)}, inputs)
        # Also before it is held, which leaves something there.
        self._check(folder)
        with held(folder) as state:
            results = ResultFolder(self, folder, state)
            results.finish()
            self._check(folder)
            for name in results.changed():
                _say(f"note: {folder / name} was changed since a run left it: it stays as it is")
            yield results

    def are_in(self, folder: Path) -> bool:
        """Whether a folder holds this command's results."""
        record = Record.read(folder / STATE / RECORD)
        return record is not None and record.command == self.command

    def is_of(self, folder: Path, key: str) -> bool:
        """Whether a folder holds this command's whole, unchanged results under a key."""
        record = Record.read(folder / STATE / RECORD)
        return (
            record is not None
            and (record.command, record.key) == (self.command, key)
            and all(_hash(folder / name) == told for name, told in record.files.items())
        )

    def _check(self, folder: Path) -> None:
        """Refuse a folder of another command, a data set's, or one in which somebody else's files lie."""
        record = Record.read(folder / STATE / RECORD)
        if record is not None and record.command != self.command:
            raise ValueError(
                f"--out {folder}: holds results of {record.command}, which would be lost; "
                "choose another folder"
            )
        recorded = {} if record is None else record.files
        # Which wrote data sets before there were records.
        own = not self.names and is_scratch(folder)
        if (folder / MANIFEST).exists() and MANIFEST not in recorded and not own:
            raise ValueError(f"--out {folder}: is a data set; choose another folder")
        started = (folder / STATE / READY).exists()
        if record is not None or started or is_committed(folder) or is_scratch(folder):
            return
        taken = of_others(folder)
        if self.goes_on:
            taken = [name for name in taken if name in self.names]
        if taken:
            more = f" and {len(taken) - LISTED} more" if len(taken) > LISTED else ""
            raise ValueError(
                f"--out {folder}: holds {', '.join(taken[:LISTED])}{more}, and no run is recorded "
                "there; choose an empty or a new folder"
            )


@dataclass(frozen=True)
class ResultFolder:
    """A folder that is held for one run.

    Attributes:
        results: What the command leaves.
        folder: Where.
        state: What runs know of one another, within `folder`.
    """

    results: ResultFiles
    folder: Path
    state: Path

    @contextmanager
    def replaced(self, key: str = "") -> Iterator[Path]:
        """A new folder to write to; at the end its files replace those of the run before.

        Whatever goes wrong before, the folder stays as it was. Other files in it stay anyway.

        Args:
            key: Hash of what decides the results, for `ResultFiles.is_of`.
        """
        new = self.state / NEW
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir()
        try:
            yield new
            names = sorted(path.relative_to(new) for path in new.rglob("*") if path.is_file())
            files = {name.as_posix(): _hash(new / name) for name in names}
            # From here on they are whole: whoever comes next finishes, if this run cannot.
            write_json(self.state / READY, Record(self.results.command, key, files))
        except BaseException as error:
            shutil.rmtree(new, ignore_errors=True)
            if isinstance(error, OSError) and error.errno in NO_ROOM:
                raise OSError(
                    f"{self.folder}: {error.strerror}: what was there stays; make room and run again"
                ) from error
            raise
        try:
            self.finish()
        except OSError as error:
            raise OSError(
                f"{self.folder}: {error.strerror or error}: the results are whole in {new}; the "
                "next run there moves them"
            ) from error

    def finish(self) -> None:
        """Move whole results into their places, the last run's out; clear what is half written."""
        new = self.state / NEW
        ready = Record.read(self.state / READY)
        if ready is not None:
            record = Record.read(self.state / RECORD)
            placed: dict[str, str] = {}
            for name, told in ready.files.items():
                if place := self._place(name, told, record):
                    placed[place] = told
            earlier = self.results.names if record is None else (*record.files, *self.results.names)
            for name in dict.fromkeys(earlier):
                if name not in placed and self._may_go(name, record):
                    _remove(self.folder / name, self.folder)
            write_json(self.state / RECORD, Record(ready.command, ready.key, placed))
        (self.state / READY).unlink(missing_ok=True)
        shutil.rmtree(new, ignore_errors=True)

    def changed(self) -> list[str]:
        """Names of the last run's files that are no longer as it left them, but there."""
        record = Record.read(self.state / RECORD)
        if record is None or is_committed(self.folder):
            return []
        present = ((name, told, _hash(self.folder / name)) for name, told in record.files.items())
        return [name for name, told, now in present if now not in ("", told)]

    def _place(self, name: str, told: str, record: Record | None) -> str:
        """Move a new file to its place, or beside what must stay there; the place that it got.

        Empty if it is gone: moved by a run that was killed, and removed since.
        """
        source, places = self.state / NEW / name, (name, _beside(name))
        if not source.is_file():
            return next((p for p in places if _hash(self.folder / p) == told), "")
        for place in places:
            if _hash(self.folder / place) == told or self._may_go(place, record):
                if place != name:
                    _say(f"note: {self.folder / name} is no run's: it stays; new is {place}")
                _move(source, self.folder / place)
                return place
        raise FileExistsError(errno.EEXIST, f"{' and '.join(places)} are there and no run's")

    def _may_go(self, name: str, record: Record | None) -> bool:
        """Whether nothing that must stay has this name: no file, or a run's as that left it."""
        now = _hash(self.folder / name)
        if now == NO_FILE:
            return False
        known = now in ("", None if record is None else record.files.get(name))
        return known or is_committed(self.folder) or (record is None and is_scratch(self.folder))


def _remove(path: Path, folder: Path) -> None:
    path.unlink(missing_ok=True)
    if path.parent != folder and path.parent.is_dir() and not any(path.parent.iterdir()):
        path.parent.rmdir()


def _beside(name: str) -> str:
    path = Path(name)
    return path.with_name(f"{path.stem}.new{path.suffix}").as_posix()


def _hash(path: Path) -> str:
    """Of a file's content; empty where there is nothing, a word where it is no file."""
    if not path.exists() and not path.is_symlink():
        return ""
    if path.is_symlink() or not path.is_file():
        return NO_FILE
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _move(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        source.replace(target)
    except OSError as error:
        if error.errno != errno.EXDEV:
            raise
        # A folder within the folder may be another mount.
        part = target.with_name(f".{target.name}.part")
        shutil.copy2(source, part)
        part.replace(target)
        source.unlink()


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")
