"""One run at a time works in a folder for results; another is told which one that is."""

from __future__ import annotations

import os
import platform
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from filelock import FileLock, Timeout

from oed.report.json_file import read_json, write_json

STATE = ".oed"  # folder within one for results: what runs know of one another
RECORD = "record.json"  # in it: what a run left, see `oed.report.result_folder`
LOCK, HOLDER = "lock", "holder.json"


@contextmanager
def held(folder: Path) -> Iterator[Path]:
    """Hold a folder until the block ends, however it ends; its state is what comes.

    The folder is made if it is not there, and removed again if nothing was left in it.

    Raises:
        ValueError: If another run holds it, or it cannot be held.
    """
    folder = folder.absolute()
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    state = folder / STATE
    was_there = state.exists()
    try:
        state.mkdir(parents=True, exist_ok=True)
        lock = FileLock(state / LOCK, timeout=0)
        lock.acquire()
    except Timeout as error:
        raise ValueError(f"--out {folder}: {_holder(state)}; choose another folder") from error
    except (OSError, NotImplementedError) as error:
        if not was_there:  # else it holds the record of a run, and results that wait
            _leave_no_trace(state, made)
        reason = getattr(error, "strerror", None) or error
        raise ValueError(
            f"--out {folder}: cannot be written: {reason}; choose another folder"
        ) from error
    try:
        with suppress(OSError):  # who it is helps another run; this one can do without
            write_json(
                state / HOLDER,
                {
                    "command": " ".join(sys.orig_argv[1:3]) if sys.argv[0] == "-m" else _command(),
                    "process": os.getpid(),
                    "host": platform.node(),
                    "since": datetime.now().astimezone().isoformat(" ", "seconds"),
                },
            )
        yield state
    finally:
        (state / HOLDER).unlink(missing_ok=True)
        if all(entry.name == LOCK for entry in state.iterdir()):
            # Nobody waits for it: a run that finds it held is refused at once.
            _leave_no_trace(state, made)
        lock.release()


def _command() -> str:
    if not sys.argv or not sys.argv[0]:
        return "a program"
    program = Path(sys.argv[0])
    # `python -m oed identify`
    name = program.parent.name if program.stem == "__main__" else program.stem
    return " ".join([name, *sys.argv[1:2]])


def _holder(state: Path) -> str:
    try:
        told = read_json(state / HOLDER)
        return (
            f"{told['command']} works there, process {told['process']} on {told['host']} since "
            f"{told['since']}: wait for it"
        )
    except (OSError, ValueError, KeyError, TypeError):
        return "another run works there: wait for it"


def _leave_no_trace(state: Path, made: list[Path]) -> None:
    shutil.rmtree(state, ignore_errors=True)
    for place in made:
        try:
            place.rmdir()
        except OSError:
            return
