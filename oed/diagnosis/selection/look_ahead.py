"""Looking ahead: terms are added with all rows, as long as they predict rows that were not fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.diagnosis.candidates.candidate import Candidate
from oed.diagnosis.evidence.moments import columns_of
from oed.diagnosis.evidence.views import Views, chosen
from oed.diagnosis.numbers import PREDICTION_GAIN, SETTLING, TESTED
from oed.diagnosis.selection.screen import Scored, evaluate, polish, price
from oed.diagnosis.selection.sign_refit import with_refitted_sign
from oed.diagnosis.selection.tables import Tables, as_term, few
from oed.dynamics.effects.on_reference import holds_reference
from oed.parallel_map import parallel_map

Say = Callable[[str], None]
Over = Callable[[], bool]


def look_ahead(
    tables: Tables, start: Views, say: Say, over: Over, refused: frozenset[str] = frozenset()
) -> Views:
    """Add what is worth most, one after another, while it predicts rows that were not fitted."""
    current = start
    while len(current.terms) < current.problem.most and not over():
        present = refused | current.labels
        found = tables.best(current, present)
        first = few(found)
        options, grown = _options(current, first)
        if grown is None:  # what is worth most may stand for what predicts no better
            options, grown = _options(current, [s for s in found if s not in first])
        if grown is None:
            break
        gain, best = options[0]
        current = _refined(with_refitted_sign(grown, "fitted"))
        say(
            f"+ {best.candidate.label}{_values(best)} {gain:.1f} nats, left "
            f"{short(current.left('fitted'))}, held out {short(current.left('held_out'))}; beside "
            + ", ".join(f"{o[1].candidate.label} {o[0]:.1f}" for o in options[1:4])
        )
    return _refined(current)


def _options(
    current: Views, tried: Sequence[Scored]
) -> tuple[list[tuple[float, Scored]], Views | None]:
    """Those that predict held-out rows better, each with what it is worth when all is refitted.

    All rows together, and those of the joint on which a term acts: it may mend others by what its
    absence had spoiled, but not at the cost of its own. Each is ranked by the channel that shows it:
    what is alike in all repetitions is worth as much in their mean as in all of them.
    """
    current.shared()

    def grown(scored: Scored) -> Views:
        return current.grown((*current.terms, as_term(scored)), "fitted")

    def worth(scored: Scored) -> float | None:
        return _worth_when_refitted(scored, grown(scored), current)

    asked = [scored for scored in tried if scored.nats > 0]
    found = zip(parallel_map(worth, asked, bytes_each=current.nbytes), asked, strict=True)
    options = sorted(((own, s) for own, s in found if own is not None), key=lambda o: -o[0])
    # Of the others their worth alone is kept: each has as many columns as all rows.
    return options, grown(options[0][1]) if options else None


def _worth_when_refitted(scored: Scored, grown: Views, current: Views) -> float | None:
    """What a candidate is worth in a model with it; None where it does not predict better.

    The log evidence of all rows: of those that are fitted, and of the others given these.
    """
    ahead, gain = grown.rise(current, "held_out"), grown.rise(current, "fitted")
    fitted = grown.showing(scored.candidate)
    rows = float(fitted.rows(chosen(fitted.problem, "fitted")).mean())
    occam = 0.5 * np.log(rows) * max(scored.worth.freedom, 1.0)
    if ahead <= PREDICTION_GAIN or gain + ahead <= occam:
        return None
    if not _serves(scored.candidate, grown, current) or not is_tested(grown):
        return None
    return float(gain + ahead - occam - price(scored.candidate, scored.values, fitted, rows))


def _serves(candidate: Candidate, grown: Views, current: Views) -> bool:
    """Whether less is left of held-out rows of the joint on which a candidate acts."""
    after, before = (
        fitted.squares(chosen(fitted.problem, "held_out"), is_ahead=True)
        for fitted in (grown.showing(candidate), current.showing(candidate))
    )
    own = slice(None) if candidate.joint is None else candidate.joint
    return bool(np.any(after[own] < before[own]))


def _refined(views: Views) -> Views:
    """The model with the shapes of each term, and of friction's sign, fitted again beside all else."""
    for _ in range(SETTLING):
        before = views
        for number, term in enumerate(views.terms):
            if not term.values:
                continue
            whole = views.showing(term.candidate)
            # A single one is as it was profiled when it was added, unless it acts by the model's own torque.
            effect = term.candidate.effect(whole.context, term.values)
            if len(views.terms) == 1 and not holds_reference(effect):
                continue
            others = views.terms[:number] + views.terms[number + 1 :]
            rest = views.grown(others, "fitted").showing(term.candidate).at_torque_of(whole)
            start = evaluate(term.candidate, term.values, rest)
            if start is None:
                continue
            best = as_term(polish(start, rest))
            if best.values == term.values:
                continue
            other = views.grown((*others[:number], best, *others[number:]), "fitted")
            views = other if other.rise(views, "fitted") > 0 else views
        views = with_refitted_sign(views, "fitted")
        if views.rise(before, "fitted") < PREDICTION_GAIN:
            break
    return views


def is_tested(views: Views) -> bool:
    """Whether held-out rows see enough of a model's last term to say whether it predicts.

    Rows determine tr((A + P)^-1 A) of a term's degrees of freedom, A the information of as many rows
    as were fitted, P its prior's precision. What the term says elsewhere is anyone's guess: of a
    smooth term where the motions that are held out visit a corner of what the others did, or go
    along their paths once more; of a formula, which speaks beyond the rows that were fitted, where
    those that are held out have none of it, such as a load that was put down before.
    """
    term = views.terms[-1]
    fitted = views.showing(term.candidate)
    own = columns_of(term, fitted, fitted.places[-1])

    def information(rows: Bool[ndarray, " rows"]) -> ndarray:
        weights = fitted.projection.weights
        return sum(
            (weights[j] ** 2 * x[rows].T @ x[rows] for j, x in own.items()), np.zeros((1, 1))
        )

    used, held = (chosen(fitted.problem, which) for which in ("fitted", "held_out"))
    if term.precision is not None:
        held = fitted.problem.rows.off_path
    seen = information(used)
    tested = information(held) * used.sum() / max(held.sum(), 1)
    precision = seen / max(used.sum(), 1) if term.precision is None else term.precision
    return _freedom(tested, precision) >= TESTED * _freedom(seen, precision) > 0


def _freedom(
    A: Float[ndarray, "columns columns"], precision: Float[ndarray, "columns columns"]
) -> float:
    return float(np.trace(np.linalg.lstsq(A + precision, A)[0]))


def _values(scored: Scored) -> str:
    """Of its nonlinear parameters, if it has any."""
    return f" {short(scored.values)}" if len(scored.values) else ""


def short(values: Sequence[float] | ndarray) -> tuple[float, ...]:
    """To three digits."""
    return tuple(float(f"{v:.3g}") for v in values)
