"""How far long work is, told to whoever listens: nobody, unless a command shows it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

# What is done, how many parts of it are, and of how many; None where that is not known.
Listener = Callable[[str, int, int | None], None]
Item = TypeVar("Item")
_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


def tell(work: str, done: int, total: int | None) -> None:
    """Tell how far some work is.

    Args:
        work: In a few words, such as "weights".
        done: Parts that are done.
        total: Parts in all; None where that is not known.
    """
    listener = _listener.get()
    if listener is not None:
        listener(work, done, total)


def told(items: Sequence[Item], work: str) -> Iterator[Item]:
    """The items one by one, telling how many are done."""
    for done, item in enumerate(items):
        tell(work, done, len(items))
        yield item
    tell(work, len(items), len(items))


@contextmanager
def heard_by(listener: Listener) -> Iterator[None]:
    """Let a listener hear what is told within."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)
