"""The page of a diagnosis: verdict first, then the evidence."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from oed.diagnosis.diagnosis import Diagnosis
from oed.diagnosis.evidence.proof import RoleProof, unseen_ratio
from oed.diagnosis.evidence.verdict import CLEAR_UNSEEN
from oed.diagnosis.rivals.discrimination import NextExperiment
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.report.diagnosis_record import NEXT
from oed.report.page import Page, Picture, Section, Table, Text, Verdict
from oed.report.provenance import Provenance


def diagnosis_page(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    data: str,
    joints: Sequence[str],
    pictures: dict[str, Path],
    provenance: Provenance,
) -> Page:
    """The page with its sections."""
    sections = [
        Section(
            "Proof: errors before and after",
            [
                Table(
                    _proof_rows(found.proof, found, joints),
                    "Errors in the analysis band; rows where the direction of motion is uncertain, "
                    "at reversals and standstill, count less",
                ),
                Picture(pictures["proof"], "Error on each kind of recording, 95 % block bootstrap"),
            ],
        ),
        Section("What was found", _effect_blocks(found)),
        Section("What has no name", _unexplained_blocks(found, joints)),
        Section(
            "How much is left, against what floor",
            [
                Text(
                    f"Noise floor from {found.noise_source}, analysis band up to "
                    f"{found.cutoff:.3g} Hz. With repetitions residuals are whitened by the noise's own "
                    "colour; without, correlated rows count less, and naming is slower."
                ),
                Table(_lack_rows(found, joints), "Lack of fit: residual over pure error, F test"),
            ],
        ),
        Section(
            "Where it lives",
            [
                Picture(pictures["dependence"], "The strongest dependences of the residual"),
                Picture(pictures["spectrum"], "Spectrum of the residual before and after"),
            ],
        ),
        Section("What was turned down", _refused_blocks(found)),
    ]
    if following is not None:
        sections.insert(2, Section("The next experiment", [Text(_next_text(following))]))
    return Page(
        title=f"What the model lacks: {data}",
        verdict=_verdict(found),
        sections=sections,
        subtitle=provenance.date,
        footer=f"commit {provenance.commit}; "
        + ", ".join(f"{name} {number}" for name, number in provenance.versions.items()),
    )


def _verdict(found: Diagnosis) -> Verdict:
    level = {"nothing found": "good", "explained": "good"}.get(found.verdict, "warning")
    notes = []
    for proof in found.proof:
        if proof.role != "estimation":
            old, new = (np.sqrt(np.sum(x**2)) for x in (proof.before, proof.after))
            notes.append(f"{proof.role} error {old:.4g} → {new:.4g} N m")
            notes += [
                f"worse on joint {j + 1}: {proof.before[j]:.4g} → {proof.after[j]:.4g} N m"
                for j in np.flatnonzero(proof.change_interval[:, 0] > 0)
            ]
    return Verdict(level, _headline(found), "; ".join(notes))  # type: ignore[arg-type]  # one of the levels


def _headline(found: Diagnosis) -> str:
    named = ", ".join(
        e.name + ("" if e.joint is None else f" on joint {e.joint + 1}") for e in found.effects
    )
    if found.verdict != "unexplained":
        return found.verdict.capitalize() + (f": {named}" if named else "")
    left = sorted({u.joint + 1 for u in found.unexplained})
    where = f" on joint{'s' * (len(left) > 1)} {', '.join(map(str, left))}" if left else ""
    if not named:
        return f"Unexplained: something without a name{where}"
    return f"Partly explained: {named}; something without a name is left{where}"


def _proof_rows(
    proofs: Sequence[RoleProof], found: Diagnosis, joints: Sequence[str]
) -> list[dict[str, str | float]]:
    return [
        {
            "recordings": p.role,
            "joint": name,
            "before [N m]": float(p.before[j]),
            "after [N m]": float(p.after[j]),
            "rows counted": f"{p.counted[j]:.0%}",
            "change, 95 % [N m]": f"{p.change_interval[j, 0]:+.3g} to {p.change_interval[j, 1]:+.3g}",
            "noise floor [N m]": float(found.noise_floor[j]),
            "relative before": float(p.before[j] / p.torque[j]),
            "relative after": float(p.after[j] / p.torque[j]),
        }
        for p in proofs
        for j, name in enumerate(joints)
    ]


def _effect_blocks(found: Diagnosis) -> list[Text | Table | Picture]:
    if not found.effects:
        return [Text("No effect of the catalogue is carried by these data.")]
    blocks: list[Text | Table | Picture] = []
    for effect in found.effects:
        place = "the whole arm" if effect.joint is None else f"joint {effect.joint + 1}"
        page = CATALOGUE[effect.name].page
        gain = effect.validation_gain
        held = "no validation recording" if gain is None else f"validation rms falls by {gain:.1%}"
        chance = f"p = {effect.p_value:.1e} after the multiplicity of the search"
        blocks.append(Text(f"{effect.name} on {place}: {page.equation}. {chance}; {held}."))
        blocks.append(
            Table(
                [
                    {"parameter": p.name, "value": p.value, "std": p.std, "unit": p.unit}
                    for p in effect.parameters
                ],
                f"Parameters of {effect.name}. {page.parameters}",
            )
        )
        if effect.rivals:
            blocks.append(
                Table(
                    [
                        {
                            "instead": r.name,
                            "joint": "arm" if r.joint is None else r.joint + 1,
                            "evidence behind": r.evidence,
                            "still possible": "yes" if r.contender else "no",
                        }
                        for r in effect.rivals
                    ],
                    "What else could have been named, and by how much it is worse "
                    "on the estimation and the validation recordings (-2 log likelihood less "
                    "penalty, in units of the misfit)",
                )
            )
        blocks.append(Text(f"Signature: {page.signature}. Exposed by: {page.exposed_by}."))
    return blocks


def _unexplained_blocks(found: Diagnosis, joints: Sequence[str]) -> list[Text | Table | Picture]:
    blocks: list[Text | Table | Picture] = []
    ratios = unseen_ratio(found.proof, found.noise_floor)
    blocks += [
        Text(
            f"On the validation recordings the error of {name} is {ratio:.2g} times the "
            "noise floor: what the model predicts there is not what happens."
        )
        for name, ratio in zip(joints, ratios, strict=True)
        if ratio > CLEAR_UNSEEN
    ]
    if not any(p.period for p in found.shop.estimation):
        blocks.append(
            Text(
                "No motion is repeated: what changes with time cannot be told from what depends "
                "on the motion, and a drift may be part of the noise floor."
            )
        )
    if not found.unexplained:
        return [*blocks, Text("No free-form term of the residual is significant.")]
    rows = [
        {
            "joint": u.joint + 1,
            "term": u.label,
            "depends on": ", ".join(u.depends_on),
            "share of residual variance": u.share,
            "part of the model": "yes" if u.stands_in else "no: does not predict unseen motion",
        }
        for u in found.unexplained
    ]
    return [*blocks, Table(rows, "Free-form terms that the data demand")]


def _lack_rows(found: Diagnosis, joints: Sequence[str]) -> list[dict[str, str | float]]:
    return [
        {
            "joint": name,
            "ratio before": float(found.lack_before.ratio[j]),
            "p before": float(found.lack_before.p_value[j]),
            "ratio after": float(found.lack_after.ratio[j]),
            "p after": float(found.lack_after.p_value[j]),
            "noise floor [N m]": float(found.noise_floor[j]),
        }
        for j, name in enumerate(joints)
    ]


def _refused_blocks(found: Diagnosis) -> list[Text | Table | Picture]:
    if not found.refused:
        return [Text("No candidate came near.")]
    seen: dict[tuple[str, int | None], dict[str, str | float]] = {}
    for r in sorted(found.refused, key=lambda r: r.gain):
        place = "arm" if r.joint is None else str(r.joint + 1)
        seen[r.name, r.joint] = {
            "candidate": r.name,
            "joint": place,
            "gain": r.gain,
            "why not": r.reason,
        }
    rows = sorted(seen.values(), key=lambda row: -float(row["gain"]))[:20]
    return [Table(rows, "The strongest of the candidates that failed a test")]


def _next_text(following: NextExperiment) -> str:
    return (
        f"To tell {'; '.join(following.pairs)}: run {NEXT}/trajectory.csv. Rivals' predictions then "
        f"differ by λ = {following.separation:.3g} (now {following.separation_now:.3g}); the chance "
        f"of naming the wrong one is {following.error_rate:.1%} (now {following.error_rate_now:.1%}). "
        f"Best of {following.tried} motions within the limits."
    )
