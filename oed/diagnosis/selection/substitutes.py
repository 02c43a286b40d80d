"""What else could stand in the place of a term."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import chi2

from oed.diagnosis.evidence.moments import columns_of
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.evidence.views import Views, moments
from oed.diagnosis.numbers import ALIKE, COMPARED, NAMED, PREDICTION_GAIN
from oed.diagnosis.selection.judge import Judged, price_of, worth_of
from oed.diagnosis.selection.look_ahead import is_tested
from oed.diagnosis.selection.screen import Scored, evaluate
from oed.diagnosis.selection.sign_refit import with_refitted_sign
from oed.diagnosis.selection.table import Line
from oed.diagnosis.selection.tables import Tables, as_term, few
from oed.parallel_map import parallel_map


@dataclass(frozen=True, eq=False)
class Substitute:
    """Something else in the place of a term.

    Attributes:
        term: It.
        nats: What it is worth there, at the term's own dilution and variance.
        is_same: Whether it gives the torque that the term gives, but for what formulas err by; a
            smooth term that is worth no more, but for what noise makes of one: a model with it, which `in_place` makes, is
            not kept, since each holds columns of all rows.
        price: -log of its prior probability [nats].
    """

    term: Term
    nats: float
    is_same: bool
    price: float


# Nats by which a substitute is excluded, however many there are of like worth.
NOT_EXCLUDED = float(np.log(NAMED / (1 - NAMED))) + float(np.log(COMPARED))


def substitutes_of(tables: Tables, whole: Views, own: Judged) -> list[Substitute]:
    """What else could stand in the place of a term, best first; the term itself is among them.

    Whatever could be preferred to the term has to predict held-out rows better than nothing does,
    as the term had to when it was added. The term with other shapes is one of them where it is
    worth more: of a formula that has several, such as a spring in stretches, a plainer one may do.
    """
    joint = own.term.candidate.joint
    excluded = own.rest.labels
    acting = _acts_on(whole, own)

    def near(line: Line) -> bool:
        candidate = line.candidate
        at = joint is None or candidate.joint in (joint, None) or candidate.is_named
        return at and not acting.isdisjoint(line.places)

    def elsewhere(line: Line) -> bool:
        """Through the base model an effect may give the same torque at a joint where it has none itself."""
        return line.candidate.kind == own.term.candidate.kind and not near(line)

    mine = _given(whole, own)
    nothing = ahead(own.rest, own.rest.terms).shared()

    def placed(scored: Scored) -> Substitute | None:
        smoothed = _as_smooth(scored, own)
        grown = in_place(whole, own, as_term(smoothed))
        # Substitutes of one size are compared at the same, smaller dilution.
        nats = _nats_in_place(grown, whole, own)
        if grown.terms[-1].label == own.term.label and nats <= own.worth.nats + PREDICTION_GAIN:
            return None
        is_excluded = nats < own.worth.nats - NOT_EXCLUDED
        if not is_excluded:
            told = ahead(grown, grown.terms)
            if told.rise(nothing, "held_out") <= 0 or not is_tested(told):
                return None
        given = _given(grown, own)
        is_same = _cosine(mine, given) > ALIKE or (
            not scored.candidate.is_named
            and nats <= own.worth.nats + PREDICTION_GAIN
            and float(np.sum((mine - given) ** 2)) < _least_noticed(smoothed, own)
        )
        cost = price_of(grown, grown.terms[-1], own.moments)
        return Substitute(grown.terms[-1], nats, is_same, cost)

    here = few(tables.best(own.rest, excluded, COMPARED, near))
    there = []
    if own.term.candidate.is_named:
        there = few(tables.best(own.rest, excluded, COMPARED, elsewhere))
    others = [scored for scored in (*here, *there) if not _is_itself(scored, own.term)]
    same = [scored.candidate for scored in others]
    asked = parallel_map(placed, others, same=same, bytes_each=whole.nbytes)
    itself = Substitute(own.term, own.worth.nats, True, price_of(whole, own.term, own.moments))
    found = [
        s for s, scored in zip(asked, others, strict=True) if s and (s.is_same or scored in here)
    ]
    return sorted([itself, *found], key=lambda r: -r.nats)


def preferred(mine: Substitute, substitutes: Sequence[Substitute]) -> Substitute | None:
    """What is better in a term's place than the term, if anything is.

    What is less than a parameter costs tells no better from worse, here as where a term is added. Of
    those that give the same torque and are worth as much, the most probable before data is better. A
    smooth term that gives the torque of a name, but for what formulas err by, is no rival of it.
    """
    names = [s for s in substitutes if s.is_same and s.term.candidate.is_named]
    rivals = [s for s in substitutes if s.term.candidate.is_named or not (names and s.is_same)]
    stands = mine if mine in rivals else names[0]
    best = rivals[0]
    if best.nats > stands.nats + PREDICTION_GAIN:
        return best
    alike = [s for s in rivals if s.is_same and s.nats > stands.nats - PREDICTION_GAIN]
    plainest = min(alike, key=_plainness)
    chosen = plainest if _plainness(plainest) < _plainness(stands) else stands
    return None if chosen is mine else chosen


def _plainness(substitute: Substitute) -> tuple[float, int]:
    return substitute.price, len(substitute.term.candidate.holds)


def _is_itself(scored: Scored, term: Term) -> bool:
    """Whether a candidate is the term with the shapes that it has; how smooth it is, the whole model says."""
    return scored.candidate is term.candidate and scored.values == term.values


def _least_noticed(scored: Scored, own: Judged) -> float:
    """Sum of squares by which noise alone makes a smooth term differ from a formula that is right."""
    freedom = max(scored.worth.freedom, 1.0)
    return own.moments.dilution * float(chi2.ppf(NAMED, freedom))


def _as_smooth(scored: Scored, own: Judged) -> Scored:
    """A smooth candidate as smooth as rows have it that count as in a term's place; a name as it is."""
    if scored.candidate.is_named:
        return scored
    fitted = own.rest.showing(scored.candidate)
    return evaluate(scored.candidate, scored.values, fitted, own.moments.dilution) or scored


def in_place(whole: Views, own: Judged, term: Term) -> Views:
    """A model with another term in the place of one."""
    grown = whole.grown((*own.rest.terms, term), "all", like=whole)
    return with_refitted_sign(grown, "all", _acting(grown, own))


def _given(whole: Views, own: Judged) -> Float[ndarray, "joints rows"]:
    """White torque that a model has beyond what is there without a term."""
    after, before = (v.showing(own.term.candidate).projection for v in (whole, own.rest))
    return (before.residual - after.residual) * before.weights[:, None]


def _cosine(one: ndarray, other: ndarray) -> float:
    lengths = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(np.sum(one * other)) / lengths if lengths > 0 else 0.0


def _acts_on(whole: Views, own: Judged) -> set[int]:
    """Joints on which a term has columns: what has none there cannot stand in its place."""
    fitted = whole.showing(own.term.candidate)
    columns = columns_of(own.term, fitted, fitted.places[whole.terms.index(own.term)])
    return {j for j, x in columns.items() if np.any(x)}


def _acting(grown: Views, own: Judged) -> set[int] | None:
    """Joints of a term and of what it stands in the place of; None for all."""
    joints = {own.term.candidate.joint, grown.terms[-1].candidate.joint}
    return None if None in joints else {j for j in joints if j is not None}


def _nats_in_place(grown: Views, whole: Views, own: Judged) -> float:
    """Worth of a model's last term in the place of another.

    Where one of them changes between repetitions, on all rows, at the larger dilution of both.
    """
    last, number = len(grown.terms) - 1, whole.terms.index(own.term)
    alike = own.term.candidate.changes == grown.terms[last].candidate.changes
    if alike:
        tau = own.moments.dilution
        return worth_of(grown, last, moments(grown, last, own.rest, tau)).nats
    pair = ((whole, number), (grown, last))
    told = [moments(views, place, own.rest, changes=True) for views, place in pair]
    tau = max(t.dilution for t in told)
    mine, other = (
        worth_of(views, place, dataclasses.replace(t, dilution=tau)).nats
        for (views, place), t in zip(pair, told, strict=True)
    )
    # Beside a term without support whatever has some is better; what is worth nothing is not.
    return other if np.isneginf(mine) or other <= 0 else own.worth.nats + other - mine


def ahead(views: Views, terms: tuple[Term, ...]) -> Views:
    """A model of these terms that is fitted without the rows that are held out."""
    return views.grown(terms, "fitted")
