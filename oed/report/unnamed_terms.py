"""What a diagnosis found and could not name: how large it is, on what it depends, which name is nearest."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace

from oed.diagnosis.candidates.candidate import NamedCandidate, SmoothCandidate
from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.inference.answer import Unexplained
from oed.diagnosis.numbers import MOSTLY
from oed.diagnosis.selection.substitutes import Substitute
from oed.dynamics.effects.catalogue import CatalogueEntry
from oed.dynamics.effects.coordinates import Coordinate
from oed.report.joint_words import COORDINATES, place_words
from oed.report.term_words import TermWords, term_words, words_of_terms
from oed.robot.robot import Joint


@dataclass(frozen=True)
class NearestName:
    """The effect of the catalogue that comes nearest to what has no name.

    Attributes:
        entry: The effect.
        words: It and, where that is another joint, its place.
        behind: Log evidence by which the best in this place is ahead of it [nats]; 0 of the best.
    """

    entry: CatalogueEntry
    words: str
    behind: float


@dataclass(frozen=True)
class Unnamed:
    """What is there at a joint and has no name.

    Attributes:
        joint: From 0.
        what: What it is, such as "torque that depends on its position", the joint's.
        model_has: What stands for it in the model, over what a curve was fitted; "nothing" where none does.
        depends_on: Coordinates such as "q_2"; none where no term describes it.
        carried: Root mean square of what the model has for it, at the joint [noise floors]; None of
            nothing.
        before: Error of the base model at the joint [noise floors].
        after: Error with all that was found [noise floors].
        nearest: None where no effect of the catalogue comes near.
    """

    joint: int
    what: str
    model_has: str
    depends_on: tuple[str, ...]
    carried: float | None
    before: float
    after: float
    nearest: NearestName | None


def unnamed_terms(found: Diagnosis) -> tuple[Unnamed, ...]:
    """All that has no name, joint after joint."""
    words = words_of_terms(found)
    ordered = sorted(found.unexplained, key=lambda u: u.joint)
    return tuple(_unnamed(found, item, words) for item in ordered)


def unexplained_words(item: Unexplained, words: Mapping[str, TermWords]) -> TermWords:
    """What has no name, in words.

    Args:
        item: It.
        words: Of the terms that the diagnosis speaks of, by label.
    """
    own = words.get(item.label)
    if own is None:
        return TermWords(place_words(item.joint), item.label)
    # A name that describes it best without being certain is no name.
    return own if own.curve else replace(own, what=f"something like {own.what}")


def _unnamed(found: Diagnosis, item: Unexplained, words: Mapping[str, TermWords]) -> Unnamed:
    j, floor = item.joint, found.noise_floor
    own = unexplained_words(item, words)
    held = next(e for e in found.errors if e.role == found.budget.role)
    substitutes = [] if item.number is None else found.selected.substitutes[item.number]
    return Unnamed(
        joint=j,
        what=own.what_at(j),
        model_has=_model_has(found, item),
        depends_on=item.depends_on,
        carried=_carried(found, item),
        before=float(held.before[j] / floor[j]),
        after=float(held.after[j] / floor[j]),
        nearest=_nearest(substitutes, words, j, _others(found, item)),
    )


def _carried(found: Diagnosis, item: Unexplained) -> float | None:
    """What the model's own term carries, which may be another than the one that is shown."""
    term = _own_term(found, item)
    if term is None:
        return None
    share = next(s for s in found.budget.shares if s.label == term.label)
    return float(share.rms[item.joint] / found.budget.floor[item.joint])


def _own_term(found: Diagnosis, item: Unexplained) -> Term | None:
    return None if item.number is None else found.selected.views.terms[item.number]


def _others(found: Diagnosis, item: Unexplained) -> set[str]:
    """Labels of what the model has besides: these are there already."""
    terms = found.selected.views.terms
    return {t.label for k, t in enumerate(terms) if k != item.number}


def _model_has(found: Diagnosis, item: Unexplained) -> str:
    term = _own_term(found, item)
    if term is None:
        return "nothing"
    own = term_words(term.candidate)
    if not isinstance(term.candidate, SmoothCandidate):
        return f"{own.what}, not certain"
    return f"{own.curve}; fitted over {_covered(term.candidate, found.before.model.robot.joints)}"


def _covered(shown: SmoothCandidate, joints: Sequence[Joint]) -> str:
    ranges = []
    for c in shown.term.coordinates:
        if isinstance(c, Coordinate):
            of_joint = c.kind != "time"
            unit = joints[c.joint].unit(COORDINATES[c.kind][1]) if of_joint else "s"
            ranges.append(f"{c.name} from {c.lower:.3g} to {c.upper:.3g} {unit}")
    return ", ".join(ranges)


def _nearest(
    substitutes: Sequence[Substitute],
    words: Mapping[str, TermWords],
    joint: int,
    others: Container[str],
) -> NearestName | None:
    """Of what was weighed in a term's place, which is best first, the first name that is not elsewhere.

    None comes near that is worth less than half of what is best there.
    """
    for s in substitutes:
        if s.nats < MOSTLY * substitutes[0].nats:
            break
        if isinstance(s.term.candidate, NamedCandidate) and s.term.label not in others:
            behind = substitutes[0].nats - s.nats
            return NearestName(s.term.candidate.entry, words[s.term.label].at(joint), behind)
    return None
