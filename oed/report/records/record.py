"""What all records have in common."""

from __future__ import annotations

from typing import Any

import msgspec

Number = float | None  # None where it is not finite, or not known
Numbers = list[Number]
Matrix = list[Numbers]
Cell = str | int | float | bool | None
# A row of a table, by the names of its columns.
Row = dict[str, Cell]
# By role of the recordings: a number a joint.
ByRole = dict[str, Numbers]


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """No field that nobody knows."""


class FileRecord(Record, frozen=True, kw_only=True):
    """A whole file.

    JSON has no number that is not finite: it is null, and `not_finite` says where it stood and
    what it was.
    """

    not_finite: dict[str, str] = msgspec.field(default_factory=dict)


class ResultRecord(FileRecord, frozen=True, kw_only=True):
    """A whole file with where it comes from: `commit` is null outside a checkout."""

    format: int
    versions: dict[str, str]
    commit: str | None


class ProvenanceRecord(FileRecord, frozen=True, kw_only=True):
    """provenance.json, as `oed.report.provenance.Provenance`."""

    seed: int | None
    configuration: dict[str, Any]
    versions: dict[str, str]
    commit: str | None
    dirty: bool | None
    date: str
    cpu: str
    python: str
    platform: str
