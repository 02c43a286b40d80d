"""The page of a diagnosis: verdict, torque budget, effects, what has no name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.diagnosis.candidates.candidate import NamedCandidate
from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.diagnosis.inference.answer import FoundEffect
from oed.report.chart import THINNED
from oed.report.diagnosis_record import NEXT
from oed.report.doubts import far_off, names_of
from oed.report.joint_words import joint_labels, over_floor, torque_units
from oed.report.next_steps import Run, next_steps
from oed.report.open_sections import steps_sections, unnamed_sections
from oed.report.page import Links, Page, Picture, Section, Table, Text, Verdict
from oed.report.provenance import Provenance
from oed.report.table import Row
from oed.report.term_words import TermWords, in_words, words_of_terms
from oed.report.torque_charts import RoleTorques, torque_charts
from oed.report.unnamed_terms import Unnamed, unnamed_terms


def diagnosis_page(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    torques: Sequence[RoleTorques],
    data: str,
    joints: Sequence[str],
    notes: Sequence[str],
    pictures: Mapping[str, Picture],
    run: Run,
    provenance: Provenance,
) -> Page:
    """The page with its sections.

    Args:
        found: The diagnosis.
        following: The motion that tells apart what is open, if anything is.
        torques: Measured torque and that of both models, role by role.
        data: Name of the data set.
        joints: (n,) names.
        notes: What is doubtful about its numbers.
        pictures: Of the errors before and after, and of what each addition gives if anything was added.
        run: Where it was made.
        provenance: Of the run.
    """
    labels = joint_labels(joints)
    words = words_of_terms(found)
    unnamed = unnamed_terms(found)
    additions = [pictures["additions"]] if "additions" in pictures else []
    sections = [
        *unnamed_sections(unnamed, labels, found.budget.role),
        *steps_sections(next_steps(found, following, run)),
        _budget_section(found, labels, words),
        *(Section("What each addition does", [picture]) for picture in additions),
        _error_section(found, labels, pictures["proof"]),
        _torque_section(found, torques),
        *(_effect_section(found, effect, labels, words) for effect in found.effects),
        *([] if following is None else [_next_section(following, words)]),
        *([Section("Notes on the data", [Text(f"{n}.") for n in notes])] if notes else []),
    ]
    return Page(
        title=f"What the model lacks: {data}",
        verdict=_verdict(found, unnamed, words),
        sections=sections,
        subtitle=f"{provenance.date[:16].replace('T', ' ')} UTC",
        footer=f"commit {provenance.commit}; "
        + ", ".join(f"{name} {number}" for name, number in provenance.versions.items()),
    )


SAYS = {
    "nothing found": "Nothing beyond noise is missing from the model, or these motions do not show it.",
    "explained": "All that was found has a name.",
    "ambiguous": "More than one name explains these recordings.",
    "unexplained": "The model lacks torque for which no effect of the catalogue is certain enough.",
}
LISTED = 3  # things without a name that a headline can hold


def _without_name(unnamed: Sequence[Unnamed]) -> str:
    """What has no name, for a headline: what it is, or at which joints where it is much."""
    if len(unnamed) <= LISTED:
        return "; ".join(f"at joint {u.joint + 1} {u.what}" for u in unnamed)
    joints = dict.fromkeys(str(u.joint + 1) for u in unnamed)
    return f"torque at joint{'s' if len(joints) > 1 else ''} {', '.join(joints)}"


def _verdict(
    found: Diagnosis, unnamed: Sequence[Unnamed], words: Mapping[str, TermWords]
) -> Verdict:
    names = ", ".join(map(names_of, found.effects))
    headline = found.verdict.capitalize() + (f": {names}" if names else "")
    if unnamed:
        headline += f"{';' if names else ','} without a name: {_without_name(unnamed)}"
    sentences = [
        f"{e.role.capitalize()} error: {over_floor(e.before, found.noise_floor):.2f} → "
        f"{over_floor(e.after, found.noise_floor):.2f} noise floors{far_off(e.after, found.noise_floor)}."
        for e in found.errors
        if e.role != "estimation"
    ]
    is_far_off = any(far_off(e.after, found.noise_floor) for e in found.errors if e.role == "test")
    told = [in_words(text, words) for text in found.contradicted]
    contradicted = [f"{text[0].upper()}{text[1:]}." for text in told]
    good = found.verdict in ("nothing found", "explained") and not (contradicted or is_far_off)
    text = " ".join([SAYS[found.verdict], *sentences, *contradicted])
    return Verdict("good" if good else "warning", headline, text)


def _budget_section(
    found: Diagnosis, labels: Sequence[str], words: Mapping[str, TermWords]
) -> Section:
    units = torque_units(found.before.model.robot.joints)
    rows: list[Row] = []
    for j, label in enumerate(labels):
        parts = [
            (words[s.label].at(j) if s.label in words else s.label, float(s.rms[j]))
            for s in found.budget.shares
            if s.rms[j] > 0
        ]
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


def _error_section(found: Diagnosis, labels: Sequence[str], picture: Picture) -> Section:
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
    noise = Text(
        f"The noise floor was read off the {found.noise_source}, in the band up to {found.cutoff:.3g} Hz."
        + _below_floor(found, labels)
    )
    return Section("Errors before and after", [picture, Table(rows, caption, digits=3), noise])


def _torque_section(found: Diagnosis, torques: Sequence[RoleTorques]) -> Section:
    known = (
        " Torque that was found before is taken off what was measured."
        if found.known.effects
        else ""
    )
    said = Text(
        f"In the band up to {found.cutoff:.3g} Hz: the base model (before), and with what was added (after).{known} {THINNED}"
    )
    charts = torque_charts(found.before.model.robot, torques, band="± the noise floor")
    return Section("Torque before and after", [said, *charts])


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
        "floor there, read off before anything was added, holds more than noise, and the noise is lower."
    )


def _effect_section(
    found: Diagnosis, effect: FoundEffect, labels: Sequence[str], words: Mapping[str, TermWords]
) -> Section:
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
            "instead": words[a.label].whole,
            "probability": f"{a.probability:.3f}",
            "": "the same on these recordings" if a.same else "open" if a.open else "excluded",
        }
        for a in effect.alternatives
    ]
    said = (
        f"Probability {effect.probability:.3f}; log evidence {effect.nats:.3g} nats; held-out rows are "
        f"predicted better by {effect.held_out_gain:.3g} nats."
    )
    page, candidate = effect.page, found.selected.views.terms[effect.number].candidate
    alike = candidate.entry.equivalent if isinstance(candidate, NamedCandidate) else ()
    blocks: list[Text | Table | Picture] = [
        Text(said),
        Text(f"{page.equation}. {page.parameters}."),
        Table(parameters, "Parameters.", digits=4),
        *([Table(others, "What else was weighed in its place.")] if others else []),
        *(Text(f"By its formula it is not told from: {text}.") for text in alike),
        Text(f"Signature: {page.signature}. Exposed by: {page.exposed_by}. Source: {page.source}."),
    ]
    return Section(f"{effect.name}, {place}", blocks)


def _next_section(following: NextExperiment, words: Mapping[str, TermWords]) -> Section:
    pairs = "; ".join(in_words(pair, words) for pair in following.pairs)
    said = (
        f"To tell {pairs}: run {NEXT}/trajectory.csv. On it their predictions differ "
        f"by λ = {following.separation:.3g}, the squared distance in variances of the noise (on the "
        f"recordings at hand {following.separation_now:.3g}); the chance of naming the wrong one is "
        f"{following.error_rate:.2%} (now {following.error_rate_now:.2%}). Best of {following.tried} "
        "motions within the limits."
    )
    page = Links(
        [("Its page", f"{NEXT}/report.html", "the moving arm, and every joint against its limits")]
    )
    return Section(
        "The next experiment", [Text(said), page, *(Text(f"{n}.") for n in following.notes)]
    )
