"""Times that are written out, 10:20:30.5 or ISO 8601, as seconds.

A time of day alone goes on through midnight. Whatever is no such time is left as it is, so that it
is named as a fault by the line and column that the user sees.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date

from oed.experiment.logs.stamps import DAY

SECOND = 10**9  # [ns]
CLOCK = re.compile(
    r"(?:(?P<date>\d{4}-\d{2}-\d{2})(?:T|\s+))?(?P<hours>\d{1,2}):(?P<minutes>\d{2}):"
    r"(?P<seconds>\d{2})(?:\.(?P<fraction>\d+))?\s*(?P<zone>Z|[+-]\d{2}(?::?\d{2})?)?"
)
DATE = re.compile(r"\d{4}-\d{2}-\d{2}|\d{1,2}[./]\d{1,2}[./]\d{4}")


def is_clock(cell: str) -> bool:
    """Whether a cell is a time that is written out."""
    return _nanoseconds(cell) is not None


def clock_seconds(cells: Sequence[str]) -> list[str]:
    """Times as decimal seconds, to the nanosecond, since midnight of the first.

    Args:
        cells: Of one column; what is no time, or has no date where the first has one, comes back
            unchanged.
    """
    first = _nanoseconds(cells[0]) if cells else None
    if first is None:
        return list(cells)
    has_date = _has_date(cells[0])
    midnight = first // DAY * DAY
    found, last, days = [], first, 0
    for cell in cells:
        stamp = _nanoseconds(cell)
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


def _nanoseconds(cell: str) -> int | None:
    """Since year 1 in universal time, or since midnight where there is no date."""
    match = CLOCK.fullmatch(cell.strip())
    if match is None:
        return None
    hours, minutes, seconds = (int(match[part]) for part in ("hours", "minutes", "seconds"))
    if hours > 24 or minutes > 59 or seconds > 60:  # 60 is a leap second
        return None
    fraction = int((match["fraction"] or "0")[:9].ljust(9, "0"))
    try:
        day = date.fromisoformat(match["date"]).toordinal() if match["date"] else 0
    except ValueError:
        return None
    clock = ((hours * 60 + minutes) * 60 + seconds) * SECOND + fraction
    return day * DAY + clock - _ahead(match["zone"])


def _ahead(zone: str | None) -> int:
    """By how much a zone is ahead of universal time [ns]."""
    if zone in (None, "Z"):
        return 0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    return int(zone[0] + "1") * (int(digits[:2]) * 60 + int(digits[2:])) * 60 * SECOND
