"""What a motion was asked to keep, and for each of these whether it does."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from oed.design.limits import KINEMATIC, Certificate, violation_of
from oed.robot import JointLimits

Standing = Literal["proven", "checked", "not checked", "given up", "not kept"]


@dataclass(frozen=True)
class LimitStatus:
    """One thing that a motion was asked to keep.

    Attributes:
        limit: What it is, such as "position" or "the box".
        standing: "proven" for all t; "checked" at instants and found to be kept; "not checked"
            where what that takes is missing; "given up" by the user's own wish; "not kept".
        evidence: Joint and ratio, least distance, or the reason.
        is_demanded: Whether the user asked for it in words, so that "not checked" will not do.
    """

    limit: str
    standing: Standing
    evidence: str = ""
    is_demanded: bool = False

    @property
    def is_open(self) -> bool:
        """Whether it stands in the way of sending the motion to an arm."""
        return self.standing == "not kept" or (self.standing == "not checked" and self.is_demanded)

    def __str__(self) -> str:
        return f"{self.limit}: {self.evidence}" if self.evidence else self.limit


@dataclass(frozen=True)
class DesignStatus:
    """All that a motion was asked to keep.

    Attributes:
        limits: Each once.
        found: How the motion was found, in a sentence.
    """

    limits: tuple[LimitStatus, ...]
    found: str = ""

    @property
    def is_usable(self) -> bool:
        """Whether the motion may be sent to an arm: nothing that must hold is open."""
        return not any(limit.is_open for limit in self.limits)

    @property
    def is_proven(self) -> bool:
        """Whether everything that was asked for is proven for all t."""
        return all(limit.standing == "proven" for limit in self.limits)

    def with_limits(self, more: Iterable[LimitStatus]) -> DesignStatus:
        """This status with further limits."""
        return DesignStatus((*self.limits, *more), self.found)

    def __str__(self) -> str:
        """One sentence that names everything that is not proven."""
        proven = ", ".join(str(limit) for limit in self.limits if limit.standing == "proven")
        if not self.is_usable:
            opened = [
                f"{limit} ({limit.standing})" if limit.standing == "not checked" else str(limit)
                for limit in self.limits
                if limit.is_open
            ]
            parts = ["NOT usable: " + "; ".join(opened)]
            parts += [f"proven: {proven}"] if proven else []
        elif self.is_proven:
            parts = [f"proven feasible: {proven}"]
        else:
            parts = [f"proven for all t: {proven}"] if proven else []
        rest = [limit for limit in self.limits if not limit.is_open]
        for standing in ("checked", "not checked", "given up"):
            told = "; ".join(str(limit) for limit in rest if limit.standing == standing)
            parts += [f"{standing}: {told}"] if told else []
        return "; ".join((*parts, *([self.found] if self.found else [])))


def certified(
    certificate: Certificate, limits: JointLimits, joint_names: Sequence[str]
) -> tuple[LimitStatus, ...]:
    """The status of each kind of limit that a certificate bounds and any joint has."""
    found = []
    for kind in (*KINEMATIC, "torque"):
        bounds, limit = getattr(certificate, kind), getattr(limits, kind)
        if bounds is None or not np.isfinite(limit).any():
            continue
        beyond = violation_of(bounds, limit)
        broken = [
            f"joint {name} beyond its limit by {share:.3g} of the half range"
            for name, share in zip(joint_names, beyond, strict=True)
            if not share <= 0.0
        ]
        evidence = ", ".join(broken)
        found.append(LimitStatus(kind, "not kept" if broken else "proven", evidence))
    found += _certified_sums(certificate, limits, joint_names)
    return tuple(found)


def _certified_sums(
    certificate: Certificate, limits: JointLimits, joint_names: Sequence[str]
) -> list[LimitStatus]:
    found = []
    beyond = violation_of(certificate.sums, limits.sum_bounds)
    for each, (low, high), share in zip(limits.sums, certificate.sums, beyond, strict=True):
        bounds = f"within {each.lower:.4g} ... {each.upper:.4g}"
        name = f"{each.told(joint_names)} {bounds}"
        if share <= 0.0:
            found.append(LimitStatus(name, "proven"))
        else:
            found.append(LimitStatus(name, "not kept", f"it reaches {low:.4g} ... {high:.4g}"))
    return found
