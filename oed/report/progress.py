"""Progress of long work: a bar on a terminal, an occasional line in a log.

Studies go through their cases by `progress`; a command shows what the library tells of itself by
`shown`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import TextIOBase
from typing import TypeVar, cast

from tqdm import tqdm

from oed.progress import heard_by

Item = TypeVar("Item")
SHORT = 2.0  # [s] of work that needs no display
EVERY = 10.0  # [s] between two lines in a log


def progress(
    items: Iterable[Item],
    label: str,
    *,
    total: int | None = None,
    every: float = EVERY,
    stream: TextIOBase | None = None,
) -> Iterator[Item]:
    """The items one by one, with a display of how far they are.

    Args:
        items: What is worked through.
        label: What the work is, in a few words.
        total: Number of items, where `items` has no length.
        every: Where the stream is no terminal, least time between two lines [s]. Work
            that is done sooner prints only its last line.
        stream: Where to display; standard error if None.
    """
    stream = cast(TextIOBase, sys.stderr) if stream is None else stream
    if total is None:
        total = len(items) if hasattr(items, "__len__") else None  # pyright: ignore[reportArgumentType]
    if stream.isatty():
        yield from tqdm(items, desc=label, total=total, file=stream, dynamic_ncols=True)
    else:
        yield from _with_lines(items, label, total, every, stream)


def _with_lines(
    items: Iterable[Item], label: str, total: int | None, every: float, stream: TextIOBase
) -> Iterator[Item]:
    of_total = "" if total is None else f"/{total}"
    start = last = time.monotonic()
    done = 0
    for item in items:
        yield item
        done += 1
        now = time.monotonic()
        if now - last >= every and done != total:
            print(f"{label}: {done}{of_total}, {now - start:.0f} s", file=stream, flush=True)
            last = now
    elapsed = time.monotonic() - start
    print(f"{label}: {done}{of_total} done in {elapsed:.1f} s", file=stream, flush=True)


@contextmanager
def shown(
    *, quiet: bool = False, every: float = EVERY, stream: TextIOBase | None = None
) -> Iterator[None]:
    """Display what the library tells of work within that takes more than two seconds.

    Args:
        quiet: Display nothing.
        every: Where the stream is no terminal, least time between two lines [s].
        stream: Where to display; standard error if None.
    """
    if quiet:
        yield
        return
    display = _Display(cast(TextIOBase, sys.stderr) if stream is None else stream, every)
    try:
        with heard_by(display.hear):
            yield
    finally:
        display.end()


class _Display:
    """One piece of work at a time, as a bar or as lines."""

    def __init__(self, stream: TextIOBase, every: float) -> None:
        self._stream, self._every = stream, every
        self._work, self._done, self._total = "", 0, None
        self._bar: tqdm | None = None
        self._start = self._last = 0.0

    def hear(self, work: str, done: int, total: int | None) -> None:
        if (work, total) != (self._work, self._total) or done < self._done:
            self.end()
            self._begin(work, total)
        self._done = done
        if self._bar is not None:
            self._bar.update(done - self._bar.n)
        if total is not None and done >= total:
            self.end()  # before what the command says of it
        if self._bar is not None or not self._work:
            return
        now = time.monotonic()
        if now - self._last >= self._every:
            self._print(f", {now - self._start:.0f} s")
            self._last = now

    def end(self) -> None:
        """Close the bar, or print the last line of work that took long and has a known size."""
        if self._bar is not None:
            self._bar.close()
        elif self._total is not None and self._work and self._is_long:
            self._print(f" done in {time.monotonic() - self._start:.1f} s")
        self._work, self._bar = "", None

    @property
    def _is_long(self) -> bool:
        return time.monotonic() - self._start >= min(SHORT, self._every)

    def _begin(self, work: str, total: int | None) -> None:
        self._work, self._total, self._done = work, total, 0
        self._start = self._last = time.monotonic()
        if self._stream.isatty():
            self._bar = tqdm(
                desc=work, total=total, file=self._stream, dynamic_ncols=True, delay=SHORT
            )

    def _print(self, told: str) -> None:
        of_total = "" if self._total is None else f"/{self._total}"
        print(f"{self._work}: {self._done}{of_total}{told}", file=self._stream, flush=True)
