"""The search: look ahead with all rows, then judge backwards by what the whole model leaves."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oed.diagnosis.evidence.views import Views
from oed.diagnosis.numbers import EXCHANGES, LOOKS, PREDICTION_GAIN
from oed.diagnosis.problem import Problem
from oed.diagnosis.selection.judge import Judged, judge, prune
from oed.diagnosis.selection.look_ahead import Over, Say, look_ahead, short
from oed.diagnosis.selection.sign_refit import with_least_torque_left
from oed.diagnosis.selection.substitutes import (
    Substitute,
    ahead,
    in_place,
    preferred,
    substitutes_of,
)
from oed.diagnosis.selection.tables import Tables
from oed.parallel_map import parallel_map, processes


@dataclass(frozen=True, eq=False)
class Selected:
    """What a search found.

    Attributes:
        views: The model that was found, on all rows.
        judged: Each of its terms.
        substitutes: Of each term, itself among them, best first.
        current: Labels of the terms whose substitutes were asked beside this very model.
    """

    views: Views
    judged: tuple[Judged, ...]
    substitutes: tuple[tuple[Substitute, ...], ...]
    current: frozenset[str]


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
        "below, left and held out are what is left at each joint, in noise floors; nats, how much "
        "likelier a term makes held-out rows; f(q_1)[39]@1, a curve over q_1 with 39 coefficients at joint 1"
    )
    say(
        f"{lines} shapes of {len(problem.candidates)} candidates, left {short(start.left('fitted'))}"
    )
    views = _ahead_and_back(tables, start, say, over)
    exchanges, found = EXCHANGES, None
    while True:
        found = _each_by_its_best(tables, views, say, found, may_exchange=exchanges > 0)
        is_exchanged = found.views is not views
        exchanges = 0 if over() else exchanges - is_exchanged
        views = found.views
        if not is_exchanged or over():
            views = keep_predictive(views, say)
            if views is found.views:
                break
        views = prune(views, say)
    return dataclasses.replace(found, views=as_handed_on(found.views, say))


def as_handed_on(views: Views, say: Say) -> Views:
    """The model estimated with nuisances or without, whichever predicts held-out rows better.

    They guard the choice of terms against noise that moves the arm. To an estimate they cost what
    their own number costs, and more where they take up what the model lacks. Signs turn as `oed
    identify` has them.
    """
    bare, gain = _without_nuisances(views)
    if gain > PREDICTION_GAIN:
        say(f"estimated without nuisances: held-out rows {gain:.1f} nats")
        views = bare
    problem = with_least_torque_left(views)
    return Views.of(problem, views.terms, "all", views, settled=True)


def _without_nuisances(views: Views) -> tuple[Views, float]:
    """The same terms estimated without nuisances, and what held-out rows gain by that [nats]."""
    bare = Views.of(views.problem.bare, views.terms, "fitted", views)
    return bare, bare.rise(ahead(views, views.terms), "held_out")


def _each_by_its_best(
    tables: Tables, views: Views, say: Say, last: Selected | None, *, may_exchange: bool
) -> Selected:
    """Each term once by what is better in its place, where anything is.

    What could stand in a term's place is asked beside all others as they are by then: a term that
    is right at last makes another's place plain.

    Args:
        tables: Of all candidates.
        views: The model.
        say: Receives lines of progress.
        last: The round before: what was asked beside the very same model is not asked again.
        may_exchange: Whether a term may be exchanged; else the model is only asked.
    """
    say(f"what else the {len(views.terms)} terms could be")
    found: dict[str, tuple[Substitute, list[Substitute]]] = {}
    told: dict[str, list[Substitute]] = {}  # beside the model as it is by then
    if last is not None and last.views is views:
        known = zip(views.terms, last.substitutes, strict=True)
        told = {t.label: list(own) for t, own in known if t.label in last.current}
    labels = [term.label for term in views.terms]
    for number, label in enumerate(labels):
        if label not in told:
            untold = [other for other in labels[number:] if other not in told]
            told |= _asked(tables, views, untold[: processes()])
        term = next(t for t in views.terms if t.label == label)
        mine = next(s for s in told[label] if s.term is term)
        better = preferred(mine, told[label]) if may_exchange else None
        chosen = better or mine
        found[chosen.term.label] = chosen, told[label]
        if better is not None:
            say(f"{label} {mine.nats:.1f} -> {better.term.label} {better.nats:.1f} nats")
            grown = in_place(views, judge(views, views.terms.index(term)), better.term)
            views = Views.of(grown.problem, grown.terms, "all", grown)
            told = {}
    placed = []
    for term in views.terms:
        chosen, substitutes = found[term.label]
        # A term that acts on the model is moved on in each refit.
        now = dataclasses.replace(chosen, term=term)
        placed.append(tuple(now if s is chosen else s for s in substitutes))
    again = tuple(judge(views, k) for k in range(len(views.terms)))
    return Selected(views, again, tuple(placed), frozenset(told))


def _asked(tables: Tables, views: Views, labels: Sequence[str]) -> dict[str, list[Substitute]]:
    """What could stand in the place of some terms of a model, each beside all others."""
    places = {term.label: number for number, term in enumerate(views.terms)}
    found = parallel_map(
        lambda number: substitutes_of(tables, views, judge(views, number)),
        [places[label] for label in labels],
        same=(*views.terms, *views.problem.candidates),
        bytes_each=views.shared().nbytes,
    )
    return dict(zip(labels, found, strict=True))


def _ahead_and_back(
    tables: Tables,
    start: Views,
    say: Say,
    over: Over,
    *,
    refused: frozenset[str] = frozenset(),
    looks: int = LOOKS,
) -> Views:
    """Look ahead and judge backwards, and once more without what was dropped."""
    grown = look_ahead(tables, start, say, over, refused)
    say(f"judging {len(grown.terms)} terms by what all of them leave")
    views = prune(Views.of(grown.problem, grown.terms, "all", grown), say)
    dropped = grown.labels - views.labels
    if not dropped or over() or looks <= 1:
        return views
    again, refused = Views.of(views.problem, views.terms, "fitted", views), refused | dropped
    return _ahead_and_back(tables, again, say, over, refused=refused, looks=looks - 1)


def keep_predictive(views: Views, say: Say) -> Views:
    """The model without terms that predict held-out rows no better, one after another.

    Where it is handed on without nuisances, each has to serve there as well as beside them.
    """
    while views.terms:
        gains = np.array(_gains_ahead(views))
        bare, gain = _without_nuisances(views)
        if gain > PREDICTION_GAIN:
            gains = np.minimum(gains, _gains_ahead(bare))
        least = int(np.argmin(gains))
        if gains[least] > 0:
            return views
        say(f"- {views.terms[least].label}: held-out rows {gains[least]:.1f} nats")
        views = views.grown(views.others(least), "all")
    return views


def _gains_ahead(views: Views) -> list[float]:
    """What each term adds to the log score of held-out rows [nats]."""
    whole = ahead(views, views.terms).shared()

    def gain(number: int) -> float:
        return whole.rise(ahead(views, views.others(number)), "held_out")

    return parallel_map(gain, range(len(views.terms)), bytes_each=whole.nbytes)
