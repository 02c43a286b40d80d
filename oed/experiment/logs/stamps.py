"""Time stamps in whole nanoseconds as seconds that lose none of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.logs.table import Table

SECOND = 10**9  # [ns]
DAY = 86_400 * SECOND
# A ROS message's time in two columns, as in header.stamp.sec beside header.stamp.nanosec.
PART = re.compile(
    r"(?P<of>.*?)[._/ ]?(?:(?P<sec>secs?|seconds)|nanosecs?|nsecs?|nanoseconds)", re.IGNORECASE
)


def seconds_of_day(stamps: Int[ndarray, " samples"]) -> Float[ndarray, " samples"]:
    """Nanoseconds since any epoch as seconds since the first stamp's midnight [s].

    Counted from 1970 in floating point, time would have steps of 0.24 microseconds. Logs of one day
    stay on one clock.
    """
    stamps = np.asarray(stamps, dtype=np.int64)
    midnight = stamps[0] // DAY * DAY if len(stamps) else 0
    return (stamps - midnight) / SECOND


def with_stamps(table: Table) -> Table:
    """The table with one column of time in place of two, of seconds and of nanoseconds [s]."""
    parts = _parts(table.columns)
    if not parts:
        return table
    of_first = {pair[0]: name for name, pair in parts.items()}
    dropped = {pair[1] for pair in parts.values()}
    columns = tuple(of_first.get(name, name) for name in table.columns if name not in dropped)

    def load(names: tuple[str, ...]) -> Mapping[str, ndarray]:
        stored = [part for name in names for part in parts.get(name, (name,))]
        values = dict(table.load(tuple(dict.fromkeys(stored))))
        for name in parts.keys() & set(names):
            sec, nanosec = parts[name]
            joined = _joined(values[sec], values[nanosec])
            if joined is None:
                message = (
                    f"no whole seconds with the nanoseconds beyond them in {nanosec!r}: remove one of "
                    "both from the log"
                )
                raise DataSetError(message, file=table.file, column=sec)
            values[name] = joined
        return {name: values[name] for name in names}

    return replace(table, columns=columns, load=load)


def _parts(columns: tuple[str, ...]) -> dict[str, tuple[str, str]]:
    """Columns of seconds and of nanoseconds by what the two are of; only where there is one of each."""
    found: dict[str, tuple[list[str], list[str]]] = {}
    for name in columns:
        if match := PART.fullmatch(name):
            whole, rest = found.setdefault(match["of"] or "stamp", ([], []))
            (whole if match["sec"] else rest).append(name)
    return {
        of: (whole[0], rest[0])
        for of, (whole, rest) in found.items()
        if len(whole) == len(rest) == 1 and of not in columns
    }


def _joined(
    sec: Float[ndarray, " samples"], nanosec: Float[ndarray, " samples"]
) -> Float[ndarray, " samples"] | None:
    """Time of both [s], no number where either is none; None if they are not parts of one time."""
    told = np.isfinite(sec) & np.isfinite(nanosec)
    whole, rest = sec[told], nanosec[told]
    if np.any(whole != np.floor(whole)) or np.any((rest < 0) | (rest >= SECOND)):
        return None
    result = np.full(len(sec), np.nan)
    result[told] = seconds_of_day(whole.astype(np.int64) * SECOND + rest.astype(np.int64))
    return result
