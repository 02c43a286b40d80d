"""Progress of long work: a bar on a terminal, an occasional line in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from io import TextIOBase
from typing import TypeVar, cast

from tqdm import tqdm

Item = TypeVar("Item")


def progress(
    items: Iterable[Item],
    label: str,
    *,
    total: int | None = None,
    every: float = 10.0,
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
