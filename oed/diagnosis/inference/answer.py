"""What may be said: names with probabilities, classes whose law is open, coordinates without a name."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import minimize_scalar

from oed.diagnosis.candidates.candidate import NamedCandidate
from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.evidence.views import Views
from oed.diagnosis.inference.estimates import Estimated, estimates
from oed.diagnosis.numbers import NAMED, PREDICTION_GAIN
from oed.diagnosis.selection.judge import Judged, excluded
from oed.diagnosis.selection.screen import ROUGH
from oed.diagnosis.selection.search import Selected
from oed.diagnosis.selection.substitutes import Substitute, ahead
from oed.dynamics.effects.catalogue import EffectPage

Outcome = Literal["nothing found", "explained", "ambiguous", "unexplained"]


@dataclass(frozen=True)
class Alternative:
    """What else a term could be.

    Attributes:
        label: In words.
        name: Of the effect; of a smooth term, "smooth term".
        joint: From 0; None for the whole arm.
        probability: Of it in this place.
        same: Whether these recordings show the same by it.
        open: Whether it is not excluded.
    """

    label: str
    name: str
    joint: int | None
    probability: float
    same: bool
    open: bool


@dataclass(frozen=True)
class FoundEffect:
    """An effect with a name, or a class of them.

    Attributes:
        name: Of the most probable member.
        joint: From 0; None for the whole arm.
        number: Of its term in the model.
        probability: Of the name at its place, with all that is the same.
        parameters: Sizes and shapes.
        alternatives: What else it could be, most probable first.
        nats: Log evidence of the term.
        held_out_gain: Log score of held-out rows with it less without [nats].
        page: What the catalogue tells of it.
    """

    name: str
    joint: int | None
    number: int
    probability: float
    parameters: tuple[Estimated, ...]
    alternatives: tuple[Alternative, ...]
    nats: float
    held_out_gain: float
    page: EffectPage

    @property
    def is_open(self) -> bool:
        """Whether another name, or this one at another place, is not excluded."""
        return any(a.open and not a.same for a in self.alternatives)


@dataclass(frozen=True)
class Unexplained:
    """What is there and has no name.

    Attributes:
        joint: From 0.
        depends_on: Coordinates; none where no term that was tried describes it.
        label: In words.
        number: Of the term that describes it; None where none does.
    """

    joint: int
    depends_on: tuple[str, ...]
    label: str
    number: int | None


@dataclass(frozen=True)
class Answer:
    """What a search lets be said.

    Attributes:
        effects: Named, in the order of what they explain.
        unexplained: Not named.
    """

    effects: tuple[FoundEffect, ...]
    unexplained: tuple[Unexplained, ...]


def answer(selected: Selected) -> Answer:
    """Name what may be named."""
    whole = selected.views.told
    effects, unexplained = [], []
    for number, (own, substitutes) in enumerate(
        zip(selected.judged, selected.substitutes, strict=True)
    ):
        term = whole.terms[number]
        found = (
            _named(selected.views, number, own, substitutes) if term.candidate.is_named else None
        )
        if found is not None:
            effects.append(found)
        else:
            unexplained.append(_unnamed(whole, number, substitutes))
    effects.sort(key=lambda e: -e.nats)
    return Answer(tuple(effects), tuple(unexplained))


def _named(
    views: Views, number: int, own: Judged, substitutes: Sequence[Substitute]
) -> FoundEffect | None:
    """The effect of a term, or None where its name is not certain enough."""
    whole = views.told
    term = own.term  # as it was judged: one that acts on the model is moved on in each refit
    candidate = term.candidate
    if not isinstance(candidate, NamedCandidate):
        return None
    nats = np.array([r.nats for r in substitutes])
    # That there is nothing is one of the alternatives.
    odds = np.exp(nats - max(float(nats.max()), 0.0))
    share = odds / (odds.sum() + np.exp(-max(float(nats.max()), 0.0)))
    alternatives, probability, named = [], 0.0, 0.0
    for substitute, p in zip(substitutes, share.tolist(), strict=True):
        other = substitute.term.candidate
        # Other shapes of one name are that name.
        same = other.label == candidate.label or substitute.is_same
        # A smooth term that gives the same torque says nothing against the name.
        if other.is_named or same:
            named += p
        if same:
            probability += p
        if other.label != candidate.label:
            alternatives.append(
                Alternative(other.label, other.kind, other.joint, p, same, p > (1 - NAMED) / 2)
            )
    foremost = max((a.probability for a in alternatives if not a.same), default=0.0)
    if named < NAMED or probability < foremost:
        return None
    gain = held_out_gain(views, number)
    if gain <= 0 or excluded(views, number) or is_driven_out(views, number):
        return None
    parameters = estimates(whole, number, own.moments.dilution)
    if _undetermined(whole, number, parameters):
        return None
    return FoundEffect(
        candidate.entry.name,
        candidate.joint,
        number,
        min(probability, 1.0),  # a sum of shares, rounded
        parameters,
        tuple(alternatives),
        own.worth.nats,
        gain,
        candidate.entry.page,
    )


def _undetermined(whole: Fitted, number: int, parameters: Sequence[Estimated]) -> bool:
    """Whether no size of a term is as large as its own uncertainty."""
    count = whole.places[number].stop - whole.places[number].start
    sizes = [p for p in parameters[:count] if p.std is not None]
    return bool(sizes) and all(abs(p.value) < (p.std or 0.0) for p in sizes)


def is_driven_out(views: Views, number: int) -> bool:
    """Whether a shape past an end of what is plausible explains more by a nat.

    Such a term is the limit of a formula, which something else has too.
    """
    term = views.terms[number]
    if not isinstance(term.candidate, NamedCandidate):
        return False

    def gain(k: int, value: float) -> float:
        values = (*term.values[:k], value, *term.values[k + 1 :])
        terms = list(views.terms)
        terms[number] = dataclasses.replace(term, values=values)
        return views.grown(tuple(terms), "all").rise(views, "all")

    for k, shape in enumerate(term.candidate.entry.shapes):
        past = shape.past(term.values[k])
        if past is None:
            continue
        best = minimize_scalar(
            lambda place, k=k, shape=shape: -gain(k, shape.outside(place)),
            bounds=past,
            method="bounded",
            options={"maxiter": ROUGH},
        )
        if -best.fun > PREDICTION_GAIN:
            return True
    return False


def held_out_gain(views: Views, number: int) -> float:
    """What a term adds to the log score of rows that neither model was fitted to [nats]."""
    rest = ahead(views, views.others(number))
    return ahead(views, views.terms).rise(rest, "held_out")


def _unnamed(whole: Fitted, number: int, substitutes: Sequence[Substitute]) -> Unexplained:
    """Coordinates of a term, or of the smooth one that describes best what it does."""
    term = whole.terms[number]
    smooth = next((r.term for r in substitutes if not r.term.candidate.is_named), None)
    shown = term if not term.candidate.is_named or smooth is None else smooth
    effect = shown.candidate.effect(whole.context, shown.values)
    joint = shown.candidate.joint
    if joint is None:
        joint = (
            int(np.argmax(whole.power(whole.places[number])))
            if whole.places[number].stop > whole.places[number].start
            else 0
        )
    return Unexplained(joint, effect.depends_on, shown.label, number)
