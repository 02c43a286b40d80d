"""The part of a diagnosis's page on one named effect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from oed.diagnosis.diagnosis import Diagnosis
from oed.diagnosis.evidence.contenders import Rival
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.verdict import FoundEffect
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.payload import PayloadChange
from oed.report.effect_words import known_parameters, place_of
from oed.report.page import Picture, Section, Table, Text
from oed.report.table import Row

SMALLEST_P = 1e-10  # below, the power of ten says nothing that a reader could use


def effect_sections(found: Diagnosis, labels: Sequence[str]) -> list[Section]:
    """A section for each named effect, or one that says there is none."""
    if not found.effects:
        return [Section(*_without_names(found))]
    return [_section(effect, found, labels) for effect in found.effects]


def _without_names(found: Diagnosis) -> tuple[str, list[Text]]:
    if found.unexplained:
        text = "Something is missing, and no effect of the catalogue proved to be what it is."
        return "Found: no name", [Text(text)]
    return "Found: nothing", [Text("The data call for no effect of the catalogue.")]


def p_value_text(p_value: float) -> str:
    """A chance with two digits, or that it is below 1e-10."""
    return f"below {SMALLEST_P:.0e}" if p_value < SMALLEST_P else f"{p_value:.2g}"


def _section(effect: FoundEffect, found: Diagnosis, labels: Sequence[str]) -> Section:
    entry = CATALOGUE[effect.name]
    about = entry.page
    rows: list[Row] = [
        {"parameter": p.label, "value": p.value, "std": p.uncertainty, "unit": p.unit}
        for p in known_parameters(effect, found.shop.context, found.before.model.robot.joints)
    ]
    blocks: list[Text | Table | Picture] = [
        Text(_evidence(effect)),
        Table(rows, f"Parameters: {about.parameters}.", digits=3),
        Text(f"Torque: {about.equation}."),
        Text(f"To be seen in the residual: {about.signature}. Exposed by: {about.exposed_by}."),
        Text(_likenesses(entry.equivalent, about.confused_with)),
    ]
    if isinstance(effect.trial.effect, PayloadChange) and found.moments:
        blocks.insert(2, Text(_moments_text(found.moments)))
    if effect.rivals:
        judges = [p.role for p in found.proof if p.role != "test"]
        blocks.append(
            Table(
                [_rival_row(rival, effect, found, labels) for rival in effect.rivals],
                "What else could have been named. Evidence: how much better the named effect "
                f"explains the {' and the '.join(judges)} recordings (-2 log likelihood less "
                "penalty, in units of the misfit); negative where the other one would explain more.",
            )
        )
    other = effect.trial.target
    coupled = f", with {labels[other[1]]}" if isinstance(other, tuple) else ""
    return Section(f"Found: {place_of(effect.name, effect.joint, labels)}{coupled}", blocks)


def _evidence(effect: FoundEffect) -> str:
    gain = effect.validation_gain
    held_out = (
        "There is no validation recording to prove it on."
        if gain is None
        else f"It lowers the validation error of its joints by {gain:.1%}."
    )
    chance = p_value_text(effect.p_value)
    return f"{held_out} Chance of as good a fit by accident, the whole search counted: {chance}."


def _moments_text(moments: Mapping[str, Estimated]) -> str:
    listed = ", ".join(
        f"{name}: {f'at {own.value:.4g} ± {own.std:.1g} s' if np.isfinite(own.value) else 'never'}"
        for name, own in moments.items()
    )
    return (
        f"Not every recording takes the load up at that moment. {listed}. These moments were read "
        "off each recording itself, the validation and test recordings too: no model can foretell "
        "them, and the errors below are those of one that knows them."
    )


def _likenesses(equivalent: Sequence[str], confused_with: Sequence[str]) -> str:
    same = f"Cannot be told, on any motion, from: {'; '.join(equivalent)}. " if equivalent else ""
    return f"{same}Easily confused, on a poor motion, with: {', '.join(confused_with)}."


def _rival_row(rival: Rival, effect: FoundEffect, found: Diagnosis, labels: Sequence[str]) -> Row:
    refused = [r.reason for r in found.refused if (r.name, r.joint) == (rival.name, rival.joint)]
    if rival.contender:
        judged = "yes"
    elif rival.is_same:
        judged = "yes: the same on any motion"
    elif effect.name in CATALOGUE[rival.name].holds:
        judged = "no: the same with parameters that are not needed"
    elif rival.evidence >= rival.margin:
        judged = "no: explains less"
    else:
        judged = f"no: {refused[-1]}" if refused else "no: fails a test"
    return {
        "instead": rival.name,
        "at": "whole arm" if rival.joint is None else labels[rival.joint],
        "evidence": round(rival.evidence),
        "still possible": judged,
    }
