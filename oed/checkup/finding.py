"""What a checkup of a data set finds, each with its evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from oed.checkup.cause import Cause

Level = Literal["green", "amber", "red"]
SEVERITY: dict[Level, int] = {"green": 0, "amber": 1, "red": 2}
EvidenceRow = Mapping[str, str | int | float | bool | None]


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    Attributes:
        topic: What was looked at, such as "rate and gaps".
        level: "green" if it is fine, "amber" if it costs accuracy, "red" if no estimate from these
            data can be trusted before it is mended.
        text: What was found, in plain sentences.
        remedy: What to do about it; empty if nothing.
        rows: The evidence, a table.
    """

    topic: str
    level: Level
    text: str
    remedy: str = ""
    rows: tuple[EvidenceRow, ...] = field(default=())

    @property
    def line(self) -> str:
        """The finding in one line."""
        return f"{self.text}; {self.remedy}" if self.remedy else self.text


@dataclass(frozen=True)
class Checkup:
    """All findings on a data set.

    Attributes:
        name: Of the data set.
        findings: In the order in which a laboratory would look.
        cause: The one thing that is wrong with the log; None where no test shows one.
    """

    name: str
    findings: tuple[Finding, ...]
    cause: Cause | None = None

    @property
    def level(self) -> Level:
        """The worst of the findings'."""
        levels: list[Level] = [finding.level for finding in self.findings]
        worst: Level = "green"
        for level in levels:
            worst = level if SEVERITY[level] > SEVERITY[worst] else worst
        return worst

    @property
    def notes(self) -> tuple[str, ...]:
        """A line for each finding that is not green, the costliest first."""
        bad = [finding for finding in self.findings if finding.level != "green"]
        bad.sort(key=lambda finding: -SEVERITY[finding.level])
        return tuple(finding.line for finding in bad)


def share(ratio: float) -> str:
    """A relative error as a reader wants it: a per cent, or a multiple where nothing is predicted."""
    return f"{multiple(ratio)} {'of ' if ratio < 1 else ''}the torque"


def multiple(ratio: float) -> str:
    """The same in short, in a list."""
    return f"{100 * ratio:.2g} %" if ratio < 1 else f"{ratio:.3g} times"
