"""Independent parts of a diagnosis on all processors, with the results of one after another.

Forked processes share all that has been laid out; what they make comes back through a file. What
they change, such as a generator's state, does not: only work that changes nothing may be given.
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import struct
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import BinaryIO, TypeVar

from oed.process_end import end_with_parent

Item = TypeVar("Item")
Result = TypeVar("Result")

PROCESSES = "OED_PROCESSES"  # environment variable: how many may be used, all processors by default
MOST_ITEMS = 512  # whose places a pipe is sure to hold
PLACE = struct.Struct("i")
NOTICE = struct.Struct("iqq")


def processes() -> int:
    """How many processes may work side by side.

    Raises:
        ValueError: If the environment says something that is no such number.
    """
    said = os.environ.get(PROCESSES)
    if said is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "fork") else 1
    if not said.isdecimal() or int(said) < 1:
        raise ValueError(f"{PROCESSES}={said!r} must be a whole number of processes, at least 1")
    return int(said)


def parallel_map(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """What is made of each item, in their order.

    Args:
        work: Changes nothing, and makes something that can be pickled.
        items: Taken one by one by whichever process is free.
    """
    helpers = min(processes(), len(items)) - 1
    if helpers < 1 or len(items) > MOST_ITEMS:
        return list(map(work, items))
    todo, places = os.pipe()
    os.write(places, b"".join(PLACE.pack(k) for k in range(len(items))))
    os.close(places)
    at_work = [_Helper.begin(work, items, todo) for _ in range(helpers)]
    made: dict[int, Result | BaseException] = {}
    results: list[Result] = []
    try:
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
    """

    child: int
    notices: int
    outcomes: BinaryIO

    @classmethod
    def begin(cls, work: Callable[[Item], Result], items: Sequence[Item], todo: int) -> _Helper:
        """Fork it."""
        read, write = os.pipe()
        outcomes = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115 open while it works
        parent = os.getpid()
        child = os.fork()
        if child:
            os.close(write)
            return cls(child, read, outcomes)
        try:
            end_with_parent(parent)
            os.environ[PROCESSES] = "1"
            start = 0
            while place := os.read(todo, PLACE.size):
                (k,) = PLACE.unpack(place)
                told = pickle.dumps(_outcome(work, items[k]), pickle.HIGHEST_PROTOCOL)
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
            # This program has written it.
            made[k] = pickle.loads(os.pread(helper.outcomes.fileno(), length, start))  # noqa: S301
        else:
            at_work.remove(helper)
            helper.end()
