"""Independent parts of a diagnosis on all processors, with the results of one after another.

Forked processes share all that has been laid out; what they make comes back through a file. What
they change, such as a generator's state, does not: only work that changes nothing may be given.
"""

from __future__ import annotations

import gc
import io
import os
import pickle
import select
import signal
import struct
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import BinaryIO, TypeVar

from oed.process_end import end_with_parent

Item = TypeVar("Item")
Result = TypeVar("Result")

PROCESSES = "OED_PROCESSES"  # environment variable: how many may be used, all processors by default
# Parts of the work whose places a pipe is sure to hold: POSIX asks for 512 bytes, a place takes four.
MOST_PARTS = 128
# That all helpers together may take beside what they share: a quarter of the 2 GB in which a diagnosis
# of a million rows is to stay.
MOST_BYTES = 500_000_000
PLACE = struct.Struct("i")
NOTICE = struct.Struct("iqq")


def processes() -> int:
    """How many processes may work side by side.

    Raises:
        ValueError: If the environment says something that is no such number.
    """
    said = os.environ.get(PROCESSES)
    if said is None:
        # Elsewhere than on Linux a fork may not survive what its libraries have begun.
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    if not said.isdecimal() or int(said) < 1:
        raise ValueError(f"{PROCESSES}={said!r} must be a whole number of processes, at least 1")
    return int(said)


def cpu_seconds() -> float:
    """CPU time of this process and of the helpers that it has had [s]."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def parallel_map(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    same: Sequence[object] = (),
    bytes_each: int = 0,
) -> list[Result]:
    """What is made of each item, in their order.

    Args:
        work: Changes nothing, and makes something that can be pickled.
        items: Taken by whichever process is free, one by one or, of many, a few neighbours at a time.
        same: What results may hold that has to come back as these very objects.
        bytes_each: About how much memory the work on an item takes.
    """
    helpers = min(processes(), len(items), 1 + MOST_BYTES // max(bytes_each, 1)) - 1
    if helpers < 1:
        return list(map(work, items))
    if len(items) > MOST_PARTS:
        few = -(-len(items) // MOST_PARTS)
        parts = [items[k : k + few] for k in range(0, len(items), few)]
        made_of = parallel_map(
            lambda part: list(map(work, part)), parts, same=same, bytes_each=bytes_each
        )
        return list(chain.from_iterable(made_of))
    todo, places = os.pipe()
    os.write(places, b"".join(PLACE.pack(k) for k in range(len(items))))
    os.close(places)
    allowed = os.environ.get(PROCESSES)
    at_work: list[_Helper] = []
    made: dict[int, Result | BaseException] = {}
    results: list[Result] = []
    try:
        os.environ[PROCESSES] = "1"  # an item's own work is not divided again
        gc.freeze()  # a collection would write to, and so copy, whatever the processes share
        at_work.extend(_Helper.begin(work, items, same, todo) for _ in range(helpers))
        for k, item in enumerate(items):
            while k not in made:
                _receive(made, at_work, wait=False)
                if k not in made:
                    place = os.read(todo, PLACE.size)
                    if place:
                        (own,) = PLACE.unpack(place)
                        made[own] = _outcome(work, items[own])
                    elif at_work:
                        _receive(made, at_work, wait=True)
                    else:  # the process that had it was ended, as where memory runs short
                        made[k] = _outcome(work, item)
            result = made.pop(k)
            if isinstance(result, BaseException):
                raise result
            results.append(result)
        return results
    finally:
        gc.unfreeze()
        os.environ.pop(PROCESSES)
        if allowed is not None:
            os.environ[PROCESSES] = allowed
        os.close(todo)
        for helper in at_work:
            helper.end()


@dataclass(frozen=True)
class _Helper:
    """A forked process that takes items.

    Attributes:
        child: Its number.
        notices: Place, start and length of each outcome that it has written.
        outcomes: File of these, one after another.
        same: What they may hold that is to stay the same.
    """

    child: int
    notices: int
    outcomes: BinaryIO
    same: Sequence[object]

    @classmethod
    def begin(
        cls,
        work: Callable[[Item], Result],
        items: Sequence[Item],
        same: Sequence[object],
        todo: int,
    ) -> _Helper:
        """Fork it."""
        read, write = os.pipe()
        outcomes = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115 open while it works
        parent = os.getpid()
        child = os.fork()
        if child:
            os.close(write)
            return cls(child, read, outcomes, same)
        try:
            end_with_parent(parent)
            start = 0
            while place := os.read(todo, PLACE.size):
                (k,) = PLACE.unpack(place)
                told = _pickled(_outcome(work, items[k]), same)
                outcomes.write(told)
                os.write(write, NOTICE.pack(k, start, len(told)))
                start += len(told)
        finally:
            os._exit(0)  # nothing of the parent's is to be cleaned up, or printed, twice

    def end(self) -> None:
        """Leave nothing of it behind."""
        os.kill(self.child, signal.SIGKILL)
        os.close(self.notices)
        self.outcomes.close()
        os.waitpid(self.child, 0)


def _outcome(work: Callable[[Item], Result], item: Item) -> Result | BaseException:
    """What is made of an item, or the error that it raises, for when its turn has come."""
    try:
        return work(item)
    except Exception as error:  # noqa: BLE001 it is raised again
        return error


def _receive(
    made: dict[int, Result | BaseException], at_work: list[_Helper], *, wait: bool
) -> None:
    """Take in what has been made elsewhere; helpers that make no more are let go."""
    ready, _, _ = select.select([h.notices for h in at_work], [], [], None if wait else 0)
    for helper in [h for h in at_work if h.notices in ready]:
        notice = os.read(helper.notices, NOTICE.size)
        if notice:
            k, start, length = NOTICE.unpack(notice)
            told = os.pread(helper.outcomes.fileno(), length, start)
            made[k] = _Reader(told, helper.same).load()
        else:
            at_work.remove(helper)
            helper.end()


class _Writer(pickle.Pickler):
    """Writes an outcome, of what is to stay the same its place alone: it lies where it lay before the fork."""

    def __init__(self, file: io.BytesIO, same: Sequence[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._places = {id(each): k for k, each in enumerate(same)}

    def persistent_id(self, obj: object) -> int | None:
        """Its place among these."""
        return self._places.get(id(obj))


class _Reader(pickle.Unpickler):
    """Reads what this program has written."""

    def __init__(self, told: bytes, same: Sequence[object]) -> None:
        super().__init__(io.BytesIO(told))
        self._same = same

    def persistent_load(self, pid: int) -> object:
        """The object at a place."""
        return self._same[pid]


def _pickled(outcome: object, same: Sequence[object]) -> bytes:
    """An outcome as it is written, or that it cannot be."""
    file = io.BytesIO()
    try:
        _Writer(file, same).dump(outcome)
    except Exception as error:  # noqa: BLE001 it is raised where the outcome is asked for
        return pickle.dumps(TypeError(f"{type(outcome).__name__} cannot be handed on: {error}"))
    return file.getvalue()
