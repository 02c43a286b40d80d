"""Times that are written out, 10:20:30.5 or ISO 8601, as seconds.

Read as well: hours to twelve with AM or PM, and dates such as 31.01.2026, 31/01/2026 or 1/31/2026.
A time of day alone goes on through midnight. Whatever is no such time is left as it is, so that it
is named as a fault by the line and column that the user sees.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from datetime import date

from oed.experiment.logs.stamps import DAY

SECOND = 10**9  # [ns]
DATE = re.compile(r"\d{4}[-/.]\d{2}[-/.]\d{2}|\d{1,2}[./]\d{1,2}[./]\d{4}")
CLOCK = re.compile(
    rf"(?:(?P<date>{DATE.pattern})(?:T|[.,]?\s+))?"
    r"(?P<hours>\d{1,2}):(?P<minutes>\d{2}):(?P<seconds>\d{2})(?:\.(?P<fraction>\d+))?\s*"
    r"(?:(?P<half>[ap])\.?\s?m\.?|(?P<zone>Z|[+-]\d{2}(?::?\d{2})?))?",
    re.IGNORECASE,
)


def is_clock(cell: str) -> bool:
    """Whether a cell is a time that is written out."""
    return any(_nanoseconds(cell, day_first) is not None for day_first in (True, False))


def clock_seconds(cells: Sequence[str]) -> list[str]:
    """Times as decimal seconds, to the nanosecond, since midnight of the first.

    Args:
        cells: Of one column; what is no time, or has no date where the first has one, comes back
            unchanged.
    """
    day_first = _is_day_first(cells)
    first = _nanoseconds(cells[0], day_first) if cells else None
    if first is None:
        return list(cells)
    has_date = _has_date(cells[0])
    midnight = first // DAY * DAY
    found, last, days = [], first, 0
    for cell in cells:
        stamp = _nanoseconds(cell, day_first)
        if stamp is None or _has_date(cell) != has_date:
            found.append(cell)
            continue
        if not has_date and stamp - last < -DAY // 2:
            days += 1
        last = stamp
        since = stamp + days * DAY - midnight
        sign, size = ("-" if since < 0 else ""), abs(since)
        found.append(f"{sign}{size // SECOND}.{size % SECOND:09d}")
    return found


def _has_date(cell: str) -> bool:
    return DATE.match(cell.strip()) is not None


def _is_day_first(cells: Iterable[str]) -> bool:
    """Whether 2/1/2026 is in January: what more of the dates can be, or what is the shorter log."""
    matches = (CLOCK.fullmatch(cell.strip()) for cell in cells)
    dates = {match["date"] for match in matches if match is not None and match["date"]}
    if not any("/" in text for text in dates):
        return True
    judged = {}
    for day_first in (True, False):
        days = [day for text in dates if (day := _day(text, day_first)) is not None]
        judged[day_first] = (-len(days), max(days, default=0) - min(days, default=0))
    return judged[True] < judged[False]


def _day(text: str, day_first: bool) -> int | None:
    """Number of a date, counted from year 1; None if there is no such date."""
    first, second, third = map(int, re.split("[-/.]", text))
    if text[:4].isdigit():
        year, month, day = first, second, third
    else:
        year, month, day = third, *((second, first) if day_first else (first, second))
    try:
        return date(year, month, day).toordinal()
    except ValueError:
        return None


def _nanoseconds(cell: str, day_first: bool) -> int | None:
    """Since year 1 in universal time, or since midnight where there is no date."""
    match = CLOCK.fullmatch(cell.strip())
    if match is None:
        return None
    hours, minutes, seconds = (int(match[part]) for part in ("hours", "minutes", "seconds"))
    if match["half"]:
        if not 1 <= hours <= 12:
            return None
        hours = hours % 12 + (12 if match["half"] in "pP" else 0)
    if hours > 24 or minutes > 59 or seconds > 60:  # 60 is a leap second
        return None
    fraction = int((match["fraction"] or "0")[:9].ljust(9, "0"))
    day = _day(match["date"], day_first) if match["date"] else 0
    if day is None:
        return None
    clock = ((hours * 60 + minutes) * 60 + seconds) * SECOND + fraction
    return day * DAY + clock - _ahead(match["zone"])


def _ahead(zone: str | None) -> int:
    """By how much a zone is ahead of universal time [ns]."""
    if zone in (None, "Z", "z"):
        return 0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    return int(zone[0] + "1") * (int(digits[:2]) * 60 + int(digits[2:])) * 60 * SECOND
