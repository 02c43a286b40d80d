"""The page of a diagnosis: verdict, torque budget, effects, what has no name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.diagnosis.inference.answer import FoundEffect
from oed.report.diagnosis_record import NEXT
from oed.report.joint_words import joint_labels, over_floor, place_words, torque_units
from oed.report.page import Page, Picture, Section, Table, Text, Verdict
from oed.report.provenance import Provenance
from oed.report.table import Row


def diagnosis_page(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    data: str,
    joints: Sequence[str],
    notes: Sequence[str],
    pictures: Mapping[str, Path],
    provenance: Provenance,
) -> Page:
    """The page with its sections.

    Args:
        found: The diagnosis.
        following: The motion that tells apart what is open, if anything is.
        data: Name of the data set.
        joints: (n,) names.
        notes: What is doubtful about its numbers.
        pictures: Of the errors before and after, and of what each addition gives if anything was added.
        provenance: Of the run.
    """
    labels = joint_labels(joints)
    sections = [
        _budget_section(found, labels),
        *_additions_section(pictures),
        _error_section(found, labels, pictures["proof"]),
        *(_effect_section(effect, labels) for effect in found.effects),
        _unnamed_section(found, labels),
        *([] if following is None else [_next_section(following)]),
        *([Section("Notes on the data", [Text(f"{n}.") for n in notes])] if notes else []),
    ]
    return Page(
        title=f"What the model lacks: {data}",
        verdict=_verdict(found),
        sections=sections,
        subtitle=f"{provenance.date[:16].replace('T', ' ')} UTC",
        footer=f"commit {provenance.commit}; "
        + ", ".join(f"{name} {number}" for name, number in provenance.versions.items()),
    )


def _left(found: Diagnosis) -> str:
    """What has no name, in words: at which joints, and what it goes with."""
    over: dict[int, dict[str, None]] = {}
    for u in sorted(found.unexplained, key=lambda u: u.joint):
        over.setdefault(u.joint + 1, {}).update(dict.fromkeys(u.depends_on))
    if not over:
        return ""
    places = [
        f"joint {joint}" + (f" (goes with {', '.join(names)})" if names else "")
        for joint, names in over.items()
    ]
    return f"; something without a name at {', '.join(places)}"


def _verdict(found: Diagnosis) -> Verdict:
    names = ", ".join(f"{e.name} ({place_words(e.joint)})" for e in found.effects)
    headline = found.verdict.capitalize() + (f": {names}" if names else "") + _left(found)
    sentences = [
        f"{e.role.capitalize()} error: {over_floor(e.before, found.noise_floor):.2f} → "
        f"{over_floor(e.after, found.noise_floor):.2f} noise floors."
        for e in found.errors
        if e.role != "estimation"
    ]
    contradicted = [f"{words[0].upper()}{words[1:]}." for words in found.contradicted]
    good = found.verdict in ("nothing found", "explained") and not contradicted
    return Verdict("good" if good else "warning", headline, " ".join([*sentences, *contradicted]))


def _budget_section(found: Diagnosis, labels: Sequence[str]) -> Section:
    units = torque_units(found.before.model.robot.joints)
    rows: list[Row] = []
    for j, label in enumerate(labels):
        parts = [(s.label, float(s.rms[j])) for s in found.budget.shares if s.rms[j] > 0]
        parts += [
            ("left", float(found.budget.left[j])),
            ("noise floor", float(found.budget.floor[j])),
        ]
        rows += [
            {
                "joint": label,
                "term": name,
                "rms": value,
                "unit": units[j],
                "noise floors": value / float(found.budget.floor[j]),
            }
            for name, value in parts
        ]
    caption = (
        f"Root mean square of what each term gives on the {found.budget.role} recordings, in the "
        "analysis band; what is left, and the noise floor, beside it."
    )
    return Section("Torque budget", [Table(rows, caption, digits=3)])


def _additions_section(pictures: Mapping[str, Path]) -> list[Section]:
    if "additions" not in pictures:
        return []
    caption = (
        "Each over the coordinate that tells most of it. Dots: mean of what is left without it, with two "
        "standard errors. Line: what it gives of that."
    )
    return [Section("What each addition does", [Picture(pictures["additions"], caption)])]


def _error_section(found: Diagnosis, labels: Sequence[str], proof: Path) -> Section:
    units = torque_units(found.before.model.robot.joints)
    rows: list[Row] = [
        {
            "recordings": e.role,
            "joint": label,
            "before": float(e.before[j]),
            "after": float(e.after[j]),
            "noise floor": float(found.noise_floor[j]),
            "unit": units[j],
            "of the torque": f"{e.before[j] / e.torque[j]:.1%} → {e.after[j] / e.torque[j]:.1%}",
        }
        for e in found.errors
        for j, label in enumerate(labels)
    ]
    caption = (
        "Root mean square errors. Linear parameters are fitted to the estimation recordings; the "
        "validation recordings had a part in choosing terms and shapes; the test recordings had none."
    )
    picture = Picture(
        proof, "Error of the base model and with what was added, 95 % block bootstrap."
    )
    noise = Text(
        f"The noise floor was read off the {found.noise_source}, in the band up to {found.cutoff:.3g} Hz."
        + _below_floor(found, labels)
    )
    return Section("Errors before and after", [picture, Table(rows, caption, digits=3), noise])


def _below_floor(found: Diagnosis, labels: Sequence[str]) -> str:
    """Where held-out errors are certainly below the floor, which then held what has been found."""
    below = [
        label
        for j, label in enumerate(labels)
        if any(
            e.role != "estimation" and e.after_interval[j, 1] < found.noise_floor[j]
            for e in found.errors
        )
    ]
    if not below:
        return ""
    return (
        f" At {', '.join(below)} less than that is left of recordings that nothing was fitted to: the "
        "floor there, read off before anything was added, holds part of what was found, and the noise "
        "is lower."
    )


def _effect_section(effect: FoundEffect, labels: Sequence[str]) -> Section:
    place = "the whole arm" if effect.joint is None else labels[effect.joint]
    parameters: list[Row] = [
        {
            "parameter": p.name,
            "value": p.value,
            "standard deviation": p.note if p.std is None else p.std,
            "unit": p.unit,
        }
        for p in effect.parameters
    ]
    others: list[Row] = [
        {
            "instead": a.label,
            "probability": f"{a.probability:.3f}",
            "": "the same on these recordings" if a.same else "open" if a.open else "excluded",
        }
        for a in effect.alternatives
    ]
    said = (
        f"Probability {effect.probability:.3f}; log evidence {effect.nats:.3g} nats; held-out rows are "
        f"predicted better by {effect.held_out_gain:.3g} nats."
    )
    page = effect.page
    blocks: list[Text | Table | Picture] = [
        Text(said),
        Text(f"{page.equation}. {page.parameters}."),
        Table(parameters, "Parameters.", digits=4),
        *([Table(others, "What else was weighed in its place.")] if others else []),
        Text(f"Signature: {page.signature}. Exposed by: {page.exposed_by}. Source: {page.source}."),
    ]
    return Section(f"{effect.name}, {place}", blocks)


def _next_section(following: NextExperiment) -> Section:
    said = (
        f"To tell {'; '.join(following.pairs)}: run {NEXT}/trajectory.csv. On it their predictions differ "
        f"by λ = {following.separation:.3g}, the squared distance in variances of the noise (on the "
        f"recordings at hand {following.separation_now:.3g}); the chance of naming the wrong one is "
        f"{following.error_rate:.2%} (now {following.error_rate_now:.2%}). Best of {following.tried} "
        "motions within the limits."
    )
    return Section("The next experiment", [Text(said), *(Text(f"{n}.") for n in following.notes)])


def _unnamed_section(found: Diagnosis, labels: Sequence[str]) -> Section:
    if not found.unexplained:
        return Section("There, but without a name", [Text("Nothing.")])
    rows: list[Row] = [
        {
            "joint": labels[u.joint],
            "described by": u.label,
            "depends on": ", ".join(u.depends_on) or "unknown",
            "error after, floors": _after(found, u.joint),
        }
        for u in found.unexplained
    ]
    return Section("There, but without a name", [Table(rows, "", digits=3)])


def _after(found: Diagnosis, joint: int) -> float:
    held = next((e for e in found.errors if e.role == found.budget.role), found.errors[0])
    return float(np.round(held.after[joint] / found.noise_floor[joint], 2))
