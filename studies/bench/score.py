"""Hold a diagnosis against the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from studies.bench.forms import OUTSIDE
from studies.bench.truth import HiddenTruth, Truth

# Equal to first order in their constant: a motion must be fast to tell them apart.
LATENESS = frozenset({"time_delay", "filter_lag"})
QUANTILE = 1.959964  # of 95 % intervals
NOTHING = "nothing found"
AMBIGUOUS = "ambiguous"


@dataclass(frozen=True)
class Claim:
    """An effect that the diagnosis names.

    Attributes:
        name: The catalogue's.
        joint: From 0; None for the whole arm.
        probability: That the name is right, as the diagnosis states it.
        rivals: (name, joint) of the alternatives that it leaves open.
        parameters: Name -> (value, standard deviation, unit).
    """

    name: str
    joint: int | None
    probability: float
    rivals: tuple[tuple[str, int | None], ...]
    parameters: Mapping[str, tuple[float, float, str]]

    @classmethod
    def read(cls, raw: Mapping[str, Any]) -> Claim:
        """From an entry of `effects` in `diagnosis.json`."""
        return cls(
            raw["name"],
            raw["joint"],
            float(raw["probability"]),
            # Runners-up that are clearly worse are listed as well: they are no rivals.
            tuple(
                (rival["name"], rival["joint"])
                for rival in raw.get("alternatives", ())
                if rival.get("contender", True)
            ),
            {
                name: (p["value"], p["std"], p["unit"])
                for name, p in raw["parameters"].items()
                if p["std"] is not None
            },
        )


@dataclass(frozen=True)
class Score:
    """How a diagnosis did.

    Attributes:
        verdict: Its own.
        claims: What it names, as "name@joint", joints from 1.
        found: Hidden effects of the catalogue that are named at the right joint.
        nearly: Of the others, those that are right but for delay against lag, or stand among
            the alternatives of a claim.
        missed: The rest.
        extra: Claims that no hidden effect accounts for.
        stated: Of each claim the probability that the diagnosis states, and whether a hidden effect
            accounts for it.
        coordinates_right: For effects outside the catalogue, whether all are traced to their
            coordinates at their joint; None where there is none.
        covered: Injected parameters within the 95 % intervals.
        compared: Parameters whose meaning is the same on both sides.
    """

    verdict: str
    claims: tuple[str, ...]
    found: int
    nearly: int
    missed: int
    extra: int
    stated: tuple[tuple[float, bool], ...]
    coordinates_right: bool | None
    covered: int
    compared: int


def score(diagnosis: Mapping[str, Any], truth: Truth, joints: int) -> Score:
    """Judge a diagnosis.

    Args:
        diagnosis: Content of `diagnosis.json`.
        truth: What is hidden.
        joints: Number of joints of the arm.
    """
    claims = [Claim.read(raw) for raw in diagnosis["effects"]]
    left = list(claims)
    found = nearly = covered = compared = 0
    named = [hidden for hidden in truth.hidden if hidden.name != OUTSIDE]
    unmatched = []
    for hidden in named:
        match = next((c for c in left if _same(hidden, c.name, c.joint, joints)), None)
        if match is None:
            unmatched.append(hidden)
            continue
        left.remove(match)
        found += 1
        inside = _inside(hidden, match)
        if inside is not None:
            covered, compared = covered + int(inside), compared + 1
    for hidden in unmatched:
        close = next((c for c in left if _close(hidden, c, joints)), None)
        if close is not None:
            left.remove(close)
            nearly += 1
    return Score(
        verdict=diagnosis["verdict"],
        claims=tuple(_label(c.name, c.joint) for c in claims),
        found=found,
        nearly=nearly,
        missed=len(named) - found - nearly,
        extra=len(left),
        stated=tuple((claim.probability, claim not in left) for claim in claims),
        coordinates_right=_coordinates_right(diagnosis["unexplained"], truth),
        covered=covered,
        compared=compared,
    )


@dataclass(frozen=True)
class ErrorRatios:
    """Errors on the test recording, joint with joint compared.

    Attributes:
        after_to_floor: Largest ratio of the error after to the noise floor.
        after_to_before: Largest ratio of the error after to that before.
        removed: Share of the excess over the floor that is gone, at the joint where it was
            largest compared with the floor; NaN if there was none.
    """

    after_to_floor: float
    after_to_before: float
    removed: float


def error_ratios(rms: Mapping[str, Mapping[str, Sequence[float]]]) -> ErrorRatios:
    """From `rms` in `diagnosis.json`."""
    before, after, floor = (
        np.array(rms[which]["test"], dtype=float) for which in ("before", "after", "noise_floor")
    )
    joint = int(np.argmax(before / floor))
    excess = [np.sqrt(max(x[joint] ** 2 - floor[joint] ** 2, 0.0)) for x in (before, after)]
    return ErrorRatios(
        float((after / floor).max()),
        float((after / before).max()),
        float(1 - excess[1] / excess[0]) if excess[0] > 0 else float("nan"),
    )


def _same(hidden: HiddenTruth, name: str, joint: int | None, joints: int) -> bool:
    """Whether a name at a joint says what is hidden, or what no motion tells from it."""
    if name != hidden.name:
        return False
    if hidden.joint is None:
        return True
    if hidden.name == "motor_coupling":  # lies between two joints
        return joint in (hidden.joint, hidden.joint + 1)
    if hidden.name == "torque_gain" and joints == 2:  # either gain is one over the other's
        return joint in (0, 1)
    return joint == hidden.joint


def _close(hidden: HiddenTruth, claim: Claim, joints: int) -> bool:
    if {hidden.name, claim.name} == LATENESS:
        return True
    return any(_same(hidden, name, joint, joints) for name, joint in claim.rivals)


def _inside(hidden: HiddenTruth, claim: Claim) -> bool | None:
    """Whether the interval holds the injected value; None if no single parameter means it."""
    if len(hidden.parameters) != 1 or claim.joint != hidden.joint:
        return None
    ((value, unit),) = hidden.parameters.values()
    alike = [(v, std) for v, std, u in claim.parameters.values() if u == unit]
    if len(alike) != 1:
        return None
    estimate, std = alike[0]
    return bool(abs(estimate - value) <= QUANTILE * std)


def _coordinates_right(unexplained: Sequence[Mapping[str, Any]], truth: Truth) -> bool | None:
    outside = [hidden for hidden in truth.hidden if hidden.name == OUTSIDE]
    if not outside:
        return None
    traced = [(entry["joint"], tuple(sorted(entry["depends_on"]))) for entry in unexplained]
    return all(
        any(joint == hidden.joint and c in hidden.coordinates for joint, c in traced)
        for hidden in outside
    )


def _label(name: str, joint: int | None) -> str:
    return name if joint is None else f"{name}@{joint + 1}"
