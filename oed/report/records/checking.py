"""What `oed check` writes."""

from __future__ import annotations

from typing import Literal

from msgspec import field

from oed.report.records.record import FileRecord, Matrix, Numbers, Record, ResultRecord, Row


class CauseRecord(Record, frozen=True, kw_only=True):
    """The one cause that a test shows, as `oed.checkup.cause.Cause`."""

    kind: str
    text: str
    remedy: str
    evidence: str


class FindingRecord(Record, frozen=True, kw_only=True):
    """One thing that was looked at, with the numbers behind it."""

    topic: str
    level: Literal["green", "amber", "red"]
    text: str
    remedy: str
    evidence: list[Row]


class CheckRecord(ResultRecord, frozen=True, kw_only=True):
    """check.json."""

    data: str
    level: Literal["green", "amber", "red"]
    cause: CauseRecord | None
    findings: list[FindingRecord]
    notes: list[str]
    command: str
    date: str


class RecordedMotionRecord(FileRecord, frozen=True, kw_only=True):
    """recorded_motion.json: instants [s] and, of each, a number a joint, in SI units."""

    kind: Literal["recorded"] = field(name="class")
    joints: list[str]
    t: Numbers
    q: Matrix
    dq: Matrix
    ddq: Matrix
