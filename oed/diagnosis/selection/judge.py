"""Judging backwards: what each term is worth by what the whole model leaves."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oed.diagnosis.evidence.criterion import Moments, Worth, worth
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.evidence.views import Views, moments
from oed.diagnosis.selection.look_ahead import Say
from oed.diagnosis.selection.screen import price
from oed.parallel_map import parallel_map


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


def judge(whole: Views, number: int, tau: float | None = None) -> Judged:
    """What a term is worth beside all else, counted by what the whole model leaves.

    Args:
        whole: With the term.
        number: Of the term.
        tau: Dilution of rows; that of what the whole model leaves if None.
    """
    rest = whole.grown(whole.others(number), "all", like=whole)
    told = moments(whole, number, rest, tau)
    return Judged(whole.terms[number], rest, told, worth_of(whole, number, told))


def worth_of(whole: Views, number: int, told: Moments) -> Worth:
    """Worth of a term by what rows tell of it; none at all where its prior has no support."""
    term = whole.terms[number]
    cost = price_of(whole, term, told)
    fixed = term.candidate.unit_coefficient
    own = worth(told, cost, term.precision, fixed=fixed, chosen=term.precision is not None)
    return own if excluded(whole, number) is None else dataclasses.replace(own, nats=-np.inf)


def excluded(whole: Views, number: int) -> str | None:
    """Why a term's prior has no support where the model has it; None where it has."""
    return whole.showing(whole.terms[number].candidate).excluded(number)


def price_of(whole: Views, term: Term, told: Moments) -> float:
    """-log prior probability of a term by the rows that tell of it [nats]."""
    fitted = whole.showing(term.candidate)
    return price(term.candidate, term.values, fitted, told.rows / told.dilution)


def resmoothed(whole: Views) -> Views:
    """The model whose smooth terms are as smooth as is worth most, counted by what all of it leaves.

    On the way ahead all rows counted, and let a term bend to what a wrong model had left. A term that
    is too stiff leaves misfit of its own, which would have it stiffer still: so each choice is judged
    by what it leaves itself.
    """
    if all(term.precision is None for term in whole.terms):
        return whole
    bent = _smoothed(whole, 1.0)
    return max((_smoothed(bent, None), bent, whole), key=_worth_of_smooth_terms)


def _worth_of_smooth_terms(whole: Views) -> float:
    smooth = [k for k, term in enumerate(whole.terms) if term.precision is not None]
    return sum(nats for nats, _ in _each(whole, smooth))


def _smoothed(whole: Views, tau: float | None) -> Views:
    """Smooth terms as smooth as rows have it at a dilution; at that of what is left if None."""
    terms = list(whole.terms)
    for k, term in enumerate(terms):
        if term.precision is not None:
            penalty = term.candidate.precision(len(term.precision))
            own = worth(judge(whole, k, tau).moments, 0.0, penalty)
            terms[k] = dataclasses.replace(term, precision=own.precision)
    return whole.grown(tuple(terms), "all")


def prune(views: Views, say: Say) -> Views:
    """Drop the term that is worth least, as long as one is worth nothing."""
    views = resmoothed(views)
    while True:
        judged = _each(views, range(len(views.terms)))
        if not judged:
            return views
        least = min(range(len(judged)), key=lambda k: judged[k])
        nats, dilution = judged[least]
        if nats > 0:
            return views
        why = excluded(views, least) or f"{nats:.1f} nats, tau {dilution:.1f}"
        say(f"- {views.terms[least].label} {why}")
        views = views.grown(views.others(least), "all")


def _each(whole: Views, numbers: Sequence[int]) -> list[tuple[float, float]]:
    """Worth [nats] and dilution of some terms of a model."""

    def of_term(number: int) -> tuple[float, float]:
        own = judge(whole, number)
        return own.worth.nats, own.moments.dilution

    return parallel_map(of_term, numbers, bytes_each=whole.shared().nbytes)
