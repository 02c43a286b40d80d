"""The page of a diagnosis: verdict first, then the evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.diagnosis import Diagnosis
from oed.diagnosis.evidence.proof import RoleProof
from oed.diagnosis.evidence.verdict import FoundEffect
from oed.diagnosis.rivals.confusion import DRAWS
from oed.diagnosis.rivals.discrimination import NextExperiment
from oed.experiment.recording import HELD_OUT
from oed.report.diagnosis_record import NEXT
from oed.report.effect_section import effect_sections, p_value_text
from oed.report.joint_words import joint_labels, over_floor, torque_units
from oed.report.page import Page, Picture, Section, Table, Text, Verdict
from oed.report.provenance import Provenance
from oed.report.table import Row
from oed.report.unexplained_section import unexplained_blocks

REFUSED = 20  # strongest of them that a reader looks at
WORSE = 1.05  # ratio of errors that is mentioned whatever its interval
RARE = 0.05  # share of draws in which noise alone would name the wrong one
NOT_FITTED: dict[tuple[str, ...], str] = {  # by the roles that there are besides estimation
    (): "Every recording was fitted: none was kept to prove it on.",
    ("validation",): "The validation recordings were not fitted; they decide what the estimation "
    "recordings leave open of an effect's shape.",
    (
        "test",
    ): "The test recordings were not fitted; they can take an addition back, and of two clocks that "
    "a change in time may go by they tell which.",
    ("validation", "test"): "Neither validation nor test recordings were fitted; what the "
    "estimation recordings leave open of an effect's shape the validation recordings decide. The "
    "test recordings can only take an addition back.",
}
ANYWAY = (
    " Were it the other one, its torque could still pass for the first: where λ is small, the plainer "
    "name wins. Where it is not, what none of them explains leaves it open, and that may be another "
    "effect."
)


def diagnosis_page(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    data: str,
    joints: Sequence[str],
    notes: Sequence[str],
    pictures: dict[str, Path],
    provenance: Provenance,
) -> Page:
    """The page with its sections.

    Args:
        found: The diagnosis.
        following: The motion that tells rivals apart, if there are any.
        data: Name of the data set.
        joints: (n,) names.
        notes: What is doubtful about its numbers.
        pictures: PNG or SVG files "proof", "dependence" and "spectrum"; "additions" if there are any.
        provenance: Of the run.
    """
    labels = joint_labels(joints)
    sections = [
        _proof_section(found, labels, pictures["proof"]),
        *([Section("Notes on the data", [Text(f"{n}.") for n in notes])] if notes else []),
        *_additions_section(pictures),
        *effect_sections(found, labels),
        Section("There, but without a name", unexplained_blocks(found, labels)),
        _lack_section(found, labels),
        Section(
            "What the residual depends on",
            [
                Picture(
                    pictures["dependence"],
                    "Mean residual over the coordinates on which it depends most, strongest first. "
                    "Bands: two standard errors of the mean; where zero lies outside, it is more "
                    "than noise. Grey: the noise floor of a single sample.",
                ),
                Picture(
                    pictures["spectrum"],
                    "Spectrum of the residual. Only what lies below the edge of the analysis band "
                    "is judged. The noise floor is drawn as if spread evenly over the band; rows at "
                    "reversals, which count less elsewhere, raise the curves above it.",
                ),
            ],
        ),
        Section("Considered and turned down", _refused_blocks(found, labels)),
    ]
    if following is not None:
        sections.insert(1, Section("The next experiment", [Text(_next_text(following))]))
    return Page(
        title=f"What the model lacks: {data}",
        verdict=_verdict(found),
        sections=sections,
        subtitle=f"{provenance.date[:16].replace('T', ' ')} UTC",
        footer=f"commit {provenance.commit}; "
        + ", ".join(f"{name} {number}" for name, number in provenance.versions.items()),
    )


def _additions_section(pictures: dict[str, Path]) -> list[Section]:
    if "additions" not in pictures:
        return []
    caption = (
        "What was added, each over the coordinates on which it depends. Dots: mean residual where "
        "all but this is fitted, with two standard errors. Line or map: what this gives of it, in "
        "the joint's unit (grey: where the arm has not been); what the rest of the model can give "
        "as well is in neither, so that it is known where the parameters below are not."
    )
    return [Section("What each addition does", [Picture(pictures["additions"], caption)])]


def _verdict(found: Diagnosis) -> Verdict:
    level = {"nothing found": "good", "explained": "good"}.get(found.verdict, "warning")
    notes = [_error_note(p, found) for p in found.proof if p.role != "estimation"]
    return Verdict(level, _headline(found), " ".join(notes))  # type: ignore[arg-type]  # one of the levels


def _error_note(proof: RoleProof, found: Diagnosis) -> str:
    old, new = (over_floor(errors, found.noise_floor) for errors in (proof.before, proof.after))
    worse = [
        f"joint {j + 1} by {proof.after[j] / proof.before[j] - 1:.1%}"
        for j in np.flatnonzero(
            (proof.change_interval[:, 0] > 0) | (proof.after > WORSE * proof.before)
        )
    ]
    note = f"{proof.role.capitalize()} error: {old:.2f} → {new:.2f} times the noise floor"
    if proof.role == "test" and found.unchecked is not None:
        first = over_floor(found.unchecked, found.noise_floor)
        note += f" ({first:.2f} with what these recordings took back)"
    return note + (f", but worse on {', '.join(worse)}." if worse else ".")


def _headline(found: Diagnosis) -> str:
    named = ", ".join(" or ".join(_possible(e)) for e in found.effects)
    left = sorted({u.joint + 1 for u in found.unexplained})
    where = f" on joint{'s' * (len(left) > 1)} {', '.join(map(str, left))}" if left else ""
    rest = f"; something without a name is left{where}"
    if found.verdict == "ambiguous":
        return f"Ambiguous: {named}{rest if left else ''}"
    if found.verdict != "unexplained":
        return found.verdict.capitalize() + (f": {named}" if named else "")
    if not named:
        return f"Unexplained: something without a name{where}"
    return f"Unexplained: {named} found{rest}"


def _possible(effect: FoundEffect) -> list[str]:
    """The named effect, and what the data cannot exclude in its place."""
    every = [effect, *(r for r in effect.rivals if r.contender)]
    return [x.name if x.joint is None else f"{x.name} on joint {x.joint + 1}" for x in every]


def _proof_section(found: Diagnosis, labels: Sequence[str], picture: Path) -> Section:
    counted = np.concatenate([p.counted for p in found.proof])
    roles = [p.role for p in found.proof]
    return Section(
        "Does it predict better? Errors before and after",
        [
            Picture(
                picture,
                "Error of the base model and with what was added, 95 % block bootstrap. "
                f"{NOT_FITTED[tuple(role for role in HELD_OUT if role in roles)]}",
            ),
            Table(
                [row for p in found.proof for row in _proof_rows(p, found, labels)],
                "Root mean square errors in the analysis band. Rows at reversals and standstill, "
                "where the direction of motion is uncertain, count less: "
                f"{counted.min():.0%} to {counted.max():.0%} of the rows are left.",
                digits=3,
            ),
        ],
    )


def _proof_rows(proof: RoleProof, found: Diagnosis, labels: Sequence[str]) -> list[Row]:
    units = torque_units(found.before.model.robot.joints)
    share_before, share_after = proof.before / proof.torque, proof.after / proof.torque
    return [
        {
            "recordings": proof.role,
            "joint": label,
            "before": float(proof.before[j]),
            "after": float(proof.after[j]),
            "noise floor": float(found.noise_floor[j]),
            "unit": units[j],
            "change, 95 %": _change(proof.change_interval[j], float(proof.before[j])),
            "of the torque": f"{share_before[j]:.1%} → {share_after[j]:.1%}",
        }
        for j, label in enumerate(labels)
    ]


def _change(interval: Float[ndarray, "2"], whole: float) -> str:
    """An interval with the decimals that show three digits of the whole."""
    decimals = max(0, 2 - math.floor(math.log10(whole)))
    return " to ".join(f"{end:+.{decimals}f}" for end in interval)


def _lack_section(found: Diagnosis, labels: Sequence[str]) -> Section:
    before, after = found.lack_before, found.lack_after
    rows = [
        {
            "joint": label,
            "before": float(before.ratio[j]),
            "chance before": p_value_text(float(before.p_value[j])),
            "after": float(after.ratio[j]),
            "chance after": p_value_text(float(after.p_value[j])),
        }
        for j, label in enumerate(labels)
    ]
    return Section(
        "Is more left than noise?",
        [
            Text(
                f"The noise floor was read off the {found.noise_source}, in the analysis band up "
                f"to {found.cutoff:.3g} Hz."
            ),
            Table(
                rows,
                "Residual on the estimation recordings over noise and encoder steps: 1 where "
                "nothing else is left, below 1 where these are overestimated. Chance: of as much "
                "from noise alone (F test for lack of fit).",
                digits=3,
            ),
        ],
    )


def _refused_blocks(found: Diagnosis, labels: Sequence[str]) -> list[Text | Table | Picture]:
    if not found.refused:
        return [Text("No candidate came near.")]
    last = {(r.name, r.joint): r for r in sorted(found.refused, key=lambda r: r.gain)}
    for kept in found.effects:  # turned down once, and found after all
        last.pop((kept.name, kept.joint), None)
    rows = [
        {
            "candidate": r.name,
            "at": "whole arm" if r.joint is None else labels[r.joint],
            "gain": round(r.gain),
            "why not": r.reason,
        }
        for r in sorted(last.values(), key=lambda r: -r.gain)[:REFUSED]
    ]
    caption = (
        "The strongest of the candidates that failed a test. Gain: by how much one would have "
        "lowered the sum of squares of the residual, in variances of the noise."
    )
    return [Table(rows, caption)]


def _next_text(following: NextExperiment) -> str:
    which, tried = "; ".join(following.pairs), following.tried
    if following.resolved < RARE:
        return (
            f"None of {tried} motions within the limits is likely to tell {which}: on the best, in "
            f"{NEXT}/trajectory.csv, their predictions differ by λ = {following.separation:.3g} (now "
            f"{following.separation_now:.3g}), the squared distance in variances of the noise, and by "
            "no more than what sampling and smoothing may make of such a torque. A log of a higher "
            "rate tells more."
        )
    return (
        f"To tell {which}: run {NEXT}/trajectory.csv. Rivals' predictions then "
        f"differ by λ = {following.separation:.3g} (now {following.separation_now:.3g}), the squared "
        "distance in variances of the noise; where the first is true, the chance of naming the other is "
        f"{_rate(following.error_rate)} (now {_rate(following.error_rate_now)}), "
        f"and that of a decisive difference {following.resolved:.0%}. "
        f"Best of {tried} motions within the limits."
        f"{ANYWAY if following.error_rate_now < RARE else ''}"
    )


def _rate(rate: float) -> str:
    """A share of draws; none of them is no proof of zero."""
    return f"{rate:.1%}" if rate > 0 else f"below {1 / DRAWS:.2%}"
