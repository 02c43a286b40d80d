"""The search: look ahead with all rows, then judge backwards by what the whole model leaves."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.candidate import Candidate
from oed.diagnosis.evidence.criterion import Moments, Worth, worth
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.evidence.views import Views, moments
from oed.diagnosis.numbers import COMPARED, EXCHANGES, LOOKS, NAMED, PREDICTION_GAIN
from oed.diagnosis.problem import Problem
from oed.diagnosis.selection.look_ahead import Over, Say, look_ahead, short
from oed.diagnosis.selection.screen import Scored, evaluate, price
from oed.diagnosis.selection.sign_refit import with_refitted_sign
from oed.diagnosis.selection.tables import Tables, as_term, few


@dataclass(frozen=True, eq=False)
class Judged:
    """A term of a whole model, and what it is worth there.

    Attributes:
        term: The one that is judged.
        rest: The model without it, its variance that of the whole.
        moments: What rows tell of it.
        worth: Of the term.
    """

    term: Term
    rest: Views
    moments: Moments
    worth: Worth


def judge(whole: Views, number: int) -> Judged:
    """What a term is worth beside all else, counted by what the whole model leaves."""
    others = tuple(t for k, t in enumerate(whole.terms) if k != number)
    rest = whole.grown(others, "all", like=whole)
    told = moments(whole, number, rest)
    return Judged(whole.terms[number], rest, told, _worth(whole, number, told))


def _worth(whole: Views, number: int, told: Moments) -> Worth:
    term = whole.terms[number]
    fitted = whole.showing(term.candidate)
    cost = price(term.candidate, term.values, fitted, told.rows / told.dilution)
    fixed = term.candidate.unit_coefficient
    return worth(told, cost, term.precision, fixed=fixed, chosen=term.precision is not None)


def resmoothed(whole: Views) -> Views:
    """The model whose smooth terms are as smooth as rows have it, counted by what all of it leaves.

    On the way ahead all rows counted, and let a term bend to what a wrong model had left.
    """
    terms = list(whole.terms)
    for k, term in enumerate(terms):
        if term.precision is not None:
            penalty = term.candidate.precision(len(term.precision))
            own = worth(judge(whole, k).moments, 0.0, penalty)
            terms[k] = dataclasses.replace(term, precision=own.precision)
    changed = any(new is not old for new, old in zip(terms, whole.terms, strict=True))
    return whole.grown(tuple(terms), "all") if changed else whole


def prune(views: Views, say: Say) -> tuple[Views, list[Judged]]:
    """Drop the term that is worth least, as long as one is worth nothing."""
    views = resmoothed(views)
    while True:
        judged = [judge(views, k) for k in range(len(views.terms))]
        if not judged:
            return views, judged
        least = min(range(len(judged)), key=lambda k: judged[k].worth.nats)
        if judged[least].worth.nats > 0:
            return views, judged
        own = judged[least]
        say(f"- {own.term.label} {own.worth.nats:.1f} nats, tau {own.moments.dilution:.1f}")
        terms = tuple(t for k, t in enumerate(views.terms) if k != least)
        views = views.grown(terms, "all")


@dataclass(frozen=True, eq=False)
class Substitute:
    """Something else in the place of a term.

    Attributes:
        term: It.
        nats: What it is worth there, at the term's own dilution and variance.
        given: (n, R) white torque that it gives there. A model with it, which `in_place` makes, is not
            kept: each holds columns of all rows.
    """

    term: Term
    nats: float
    given: Float[ndarray, "joints rows"]


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

    def near(candidate: Candidate) -> bool:
        return joint is None or candidate.joint in (joint, None) or candidate.is_named

    found = [Substitute(own.term, own.worth.nats, _given(whole, own))]
    nothing = ahead(own.rest, own.rest.terms)
    for scored in few(tables.best(own.rest, excluded, COMPARED, near)):
        grown = in_place(whole, own, as_term(_as_smooth(scored, own)))
        # Substitutes of one size are compared at the same, smaller dilution.
        nats = _nats_in_place(grown, whole, own)
        substitute = Substitute(grown.terms[-1], nats, _given(grown, own))
        if substitute.term.label == own.term.label and nats <= own.worth.nats + PREDICTION_GAIN:
            continue
        if (
            substitute.nats < own.worth.nats - NOT_EXCLUDED
            or ahead(grown, grown.terms).rise(nothing, "held_out") > 0
        ):
            found.append(substitute)
    return sorted(found, key=lambda r: -r.nats)


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


def _acting(grown: Views, own: Judged) -> set[int] | None:
    """Joints of a term and of what it stands in the place of; None for all."""
    joints = {own.term.candidate.joint, grown.terms[-1].candidate.joint}
    return None if None in joints else {j for j in joints if j is not None}


def _nats_in_place(grown: Views, whole: Views, own: Judged) -> float:
    """Worth of a model's last term in the place of another; on all rows where one of them changes."""
    last, number = len(grown.terms) - 1, whole.terms.index(own.term)
    alike = own.term.candidate.changes == grown.terms[last].candidate.changes

    def nats(views: Views, place: int) -> float:
        tau, changes = own.moments.dilution, None if alike else True
        return _worth(views, place, moments(views, place, own.rest, tau, changes=changes)).nats

    return nats(grown, last) if alike else own.worth.nats + nats(grown, last) - nats(whole, number)


@dataclass(frozen=True, eq=False)
class Selected:
    """What a search found.

    Attributes:
        views: The model that was found, on all rows.
        judged: Each of its terms.
        substitutes: Of each term, itself among them, best first.
    """

    views: Views
    judged: tuple[Judged, ...]
    substitutes: tuple[tuple[Substitute, ...], ...]


def search(problem: Problem, say: Say = lambda _: None, over: Over = lambda: False) -> Selected:
    """Find what a base model lacks.

    Args:
        problem: Rows, base model and candidates; no test recording is among them.
        say: Receives lines of progress.
        over: Whether the time for it is over: what was found so far is judged and returned.
    """
    start = Views.of(problem, (), "fitted")
    tables = Tables.of(start, problem.candidates)
    lines = len(tables.alike.lines) + len(tables.changing.lines)
    say(
        f"{lines} shapes of {len(problem.candidates)} candidates, left {short(start.left('fitted'))}"
    )
    views, judged = _ahead_and_back(tables, start, say, over)
    exchanges, substitutes = EXCHANGES, ()
    while True:
        better, is_over = None, over()
        if not is_over:
            substitutes = _substitutes(tables, views, judged, say)
            better = _better(views, judged, substitutes) if exchanges else None
        if better is not None:
            own, best, grown = better
            exchanges -= 1
            say(f"{own.term.label} {own.worth.nats:.1f} -> {best.term.label} {best.nats:.1f} nats")
            changed = Views.of(grown.problem, grown.terms, "all", grown)
        else:
            changed = _predictive(views, say)
            if changed is views:
                break
        views, judged = prune(changed, say)
    if is_over:
        substitutes = _substitutes(tables, views, judged, say)
    return Selected(views, tuple(judged), substitutes)


def _substitutes(
    tables: Tables, views: Views, judged: Sequence[Judged], say: Say
) -> tuple[tuple[Substitute, ...], ...]:
    say(f"what else the {len(judged)} terms could be")
    return tuple(tuple(substitutes_of(tables, views, own)) for own in judged)


def _ahead_and_back(
    tables: Tables,
    start: Views,
    say: Say,
    over: Over,
    *,
    refused: frozenset[str] = frozenset(),
    looks: int = LOOKS,
) -> tuple[Views, list[Judged]]:
    """Look ahead and judge backwards, and once more without what was dropped."""
    grown = look_ahead(tables, start, say, over, refused)
    say(f"judging {len(grown.terms)} terms by what all of them leave")
    views, judged = prune(Views.of(grown.problem, grown.terms, "all", grown), say)
    dropped = grown.labels - views.labels
    if not dropped or over() or looks <= 1:
        return views, judged
    again, refused = Views.of(views.problem, views.terms, "fitted", views), refused | dropped
    return _ahead_and_back(tables, again, say, over, refused=refused, looks=looks - 1)


def ahead(views: Views, terms: tuple[Term, ...]) -> Views:
    """A model of these terms that is fitted without the rows that are held out."""
    return views.grown(terms, "fitted")


def _predictive(views: Views, say: Say) -> Views:
    """The model without terms that predict held-out rows no better, one after another."""
    while views.terms:
        whole = ahead(views, views.terms)
        rest = [views.terms[:k] + views.terms[k + 1 :] for k in range(len(views.terms))]
        gains = [whole.rise(ahead(views, others), "held_out") for others in rest]
        least = int(np.argmin(gains))
        if gains[least] > 0:
            return views
        say(f"- {views.terms[least].label}: held-out rows {gains[least]:.1f} nats")
        views = views.grown(rest[least], "all")
    return views


def _better(
    views: Views, judged: Sequence[Judged], substitutes: Sequence[Sequence[Substitute]]
) -> tuple[Judged, Substitute, Views] | None:
    """The exchange that raises the evidence most and predicts held-out rows no worse, if one does.

    What is less than a parameter costs tells no better from worse, here as where a term is added.
    """
    pairs = [
        (own, best)
        for own, (best, *_) in zip(judged, substitutes, strict=True)
        if best.term is not own.term and best.nats > own.worth.nats + PREDICTION_GAIN
    ]
    pairs.sort(key=lambda pair: pair[0].worth.nats - pair[1].nats)
    now = ahead(views, views.terms)

    for own, best in pairs:
        grown = in_place(views, own, best.term)
        if ahead(grown, grown.terms).rise(now, "held_out") > -PREDICTION_GAIN:
            return own, best, grown
    return None
