"""Independent parts of a diagnosis on all processors, with the results of one after another.

Forked processes share all that has been laid out; what they make comes back through a pipe. What
they change, such as a generator's state, does not: only work that changes nothing may be given.
"""

from __future__ import annotations

import os
import pickle
import signal
import struct
from collections.abc import Callable, Iterator, Sequence
from typing import BinaryIO, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

PROCESSES = "OED_PROCESSES"  # environment variable: how many may be used, all processors by default
MOST_ITEMS = 512  # whose places a pipe is sure to hold
PLACE = struct.Struct("i")


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


def side_by_side(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """What is made of each item, in their order.

    Args:
        work: Changes nothing, and makes something that can be pickled.
        items: Taken one by one by whichever process is free.
    """
    helpers = min(processes(), len(items)) - 1
    if helpers < 1 or len(items) > MOST_ITEMS:
        return [work(item) for item in items]
    todo, places = os.pipe()
    os.write(places, b"".join(PLACE.pack(k) for k in range(len(items))))
    os.close(places)
    children = [_fork(work, items, todo) for _ in range(helpers)]
    made: dict[int, Result] = {}
    try:
        made.update(_taken(work, items, todo))
        for _, results in children:
            made.update(_received(results))
        made |= {k: work(items[k]) for k in range(len(items)) if k not in made}
    except BaseException:
        for child, _ in children:
            os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.close(todo)
        for child, results in children:
            results.close()
            os.waitpid(child, 0)
    return [made[k] for k in range(len(items))]


def one_by_one(work: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """The same for one who may stop at any: as many at once as there are processes.

    Args:
        work: Changes nothing, and makes something that can be pickled.
        items: Taken in their order.
    """
    at_once = processes()
    for start in range(0, len(items), at_once):
        yield from side_by_side(work, items[start : start + at_once])


def _taken(
    work: Callable[[Item], Result], items: Sequence[Item], todo: int
) -> Iterator[tuple[int, Result]]:
    """The items that are left when this process is free, each with its place."""
    while place := os.read(todo, PLACE.size):
        (k,) = PLACE.unpack(place)
        yield k, work(items[k])


def _fork(work: Callable[[Item], Result], items: Sequence[Item], todo: int) -> tuple[int, BinaryIO]:
    """A process that takes items, and where its results come from."""
    read, write = os.pipe()
    child = os.fork()
    if child:
        os.close(write)
        return child, os.fdopen(read, "rb")
    os.environ[PROCESSES] = "1"
    try:
        outcome = dict(_taken(work, items, todo))
    except BaseException as error:  # noqa: BLE001 it is raised again where the results are read
        outcome = error
    try:
        with os.fdopen(write, "wb") as results:
            pickle.dump(outcome, results, protocol=pickle.HIGHEST_PROTOCOL)
    finally:
        os._exit(0)  # nothing of the parent's is to be cleaned up, or printed, twice


def _received(results: BinaryIO) -> dict[int, Result]:
    """What a process has made; nothing of one that the system ended, as where memory runs short."""
    written = results.read()
    if not written:
        return {}
    outcome = pickle.loads(written)  # noqa: S301 this program has written it
    if isinstance(outcome, BaseException):
        raise outcome
    return outcome
