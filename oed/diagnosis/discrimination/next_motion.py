"""The motion on which two explanations of the data differ most (T-optimality).

Atkinson and Fedorov 1975, "The design of experiments for discriminating between two rival
models", Biometrika 62(1): maximise lambda = min over the other's parameters of the squared white
distance between its prediction and that of the one that is taken for true. Two explanations of equal
freedom are then confused with the probability Phi(-sqrt(lambda) / 2).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from oed.diagnosis.diagnose import Diagnosis, predictor
from oed.diagnosis.discrimination.unrun_motions import as_prepared, random_motions
from oed.diagnosis.evidence.model import Fitted, fit
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.inference.errors import Predictor
from oed.diagnosis.numbers import REFITTED
from oed.diagnosis.problem import Problem
from oed.diagnosis.rows.white_rows import WhiteRows
from oed.diagnosis.selection.screen import evaluate, polish
from oed.diagnosis.selection.substitutes import in_place
from oed.diagnosis.selection.tables import as_term
from oed.dynamics.motion import Motion
from oed.dynamics.velocity_sign import sign_terms
from oed.estimation.noise_floor.weighted_rows import weigh
from oed.experiment.preparation.prepared import Prepared


@dataclass(frozen=True, eq=False)
class Pair:
    """An effect and what is not excluded in its place.

    Attributes:
        label: Of both, in words.
        favourite: The model with the effect.
        alternative: The model with the other in its place; that is its last term.
    """

    label: str
    favourite: Fitted
    alternative: Fitted


@dataclass(frozen=True)
class NextExperiment:
    """A motion that tells alternatives apart.

    Attributes:
        motion: One period on the fine grid.
        separation: lambda on the new motion alone, the least over the pairs.
        separation_now: lambda on the recordings at hand.
        error_rate: Predicted chance that the new motion names the other, the largest over the pairs.
        error_rate_now: The same on the recordings at hand.
        pairs: In words.
        tried: Motions that were compared.
        notes: Limits that had to be assumed.
    """

    motion: Motion
    separation: float
    separation_now: float
    error_rate: float
    error_rate_now: float
    pairs: tuple[str, ...]
    tried: int
    notes: tuple[str, ...]


def open_pairs(found: Diagnosis) -> list[Pair]:
    """Effects whose name is open, each with what is not excluded in its place.

    What changes from one repetition to the next is left out: no motion shows it.
    """
    selected, pairs = found.selected, []
    whole = selected.views.means
    for effect in found.effects:
        own = selected.judged[effect.number]
        term = whole.terms[effect.number]
        still_open = {a.label for a in effect.alternatives if a.open and not a.same}
        for substitute in selected.substitutes[effect.number]:
            other = substitute.term.candidate
            if other.label in still_open and not (other.changes or term.candidate.changes):
                label = f"{term.label} or {other.label}"
                instead = in_place(selected.views, own, substitute.term)
                pairs.append(Pair(label, whole, instead.means))
    return pairs


def design_next(
    found: Diagnosis, rng: np.random.Generator, *, candidates: int = 48
) -> NextExperiment | None:
    """The best of a number of random motions within the limits; None where no name is open.

    The new motion is taken to be run as many times as the first recording's.

    Args:
        found: The diagnosis.
        rng: Draws motions.
        candidates: Motions to compare.
    """
    pairs = open_pairs(found)
    if not pairs:
        return None
    problem = found.selected.views.means.problem
    pattern = problem.rows.prepared[0]
    motions, notes = random_motions(found.before.model.robot, pattern, rng, candidates)

    def least(recordings: Sequence[Prepared], *, shapes: bool) -> float:
        return min(separation(found, pair, recordings, shapes=shapes) for pair in pairs)

    laid = [(as_prepared(pattern, motion),) for motion in motions]
    promised = [least(own, shapes=False) for own in laid]
    leading = np.argsort([-x for x in promised], kind="stable")[:REFITTED]
    refitted = {int(k): least(laid[k], shapes=True) for k in leading}
    best = max(refitted, key=lambda k: refitted[k])
    now = least(problem.rows.prepared, shapes=True)
    return NextExperiment(
        motion=motions[best],
        separation=refitted[best],
        separation_now=now,
        error_rate=error_rate(refitted[best]),
        error_rate_now=error_rate(now),
        pairs=tuple(pair.label for pair in pairs),
        tried=candidates,
        notes=notes,
    )


def error_rate(separation: float) -> float:
    """Chance that noise makes the wrong one of two models without free shapes fit better."""
    return float(norm.cdf(-np.sqrt(max(separation, 0.0)) / 2))


def separation(
    found: Diagnosis, pair: Pair, recordings: Sequence[Prepared], *, shapes: bool = True
) -> float:
    """lambda: white squares of the favourite's torque that the alternative does not reproduce.

    Args:
        found: Gives the noise.
        pair: Favourite and alternative.
        recordings: With the motions; their torque is the favourite's.
        shapes: Whether the alternative's shapes are fitted too, or stay as they are.
    """
    problem = _told_by(found, pair.favourite, recordings)
    terms = pair.alternative.terms
    every = np.ones(problem.rows.torque.shape[1], dtype=bool)
    ones = np.ones(problem.rows.joints)
    problem = dataclasses.replace(
        problem, base=pair.alternative.problem.base, context=pair.alternative.problem.context
    )

    def left(last: Term) -> float:
        fitted = fit(problem, (*terms[:-1], last), every, variance=ones)
        return float(fitted.squares(every).sum())

    result = left(terms[-1])
    if not shapes or not terms[-1].values:
        return result
    rest = fit(problem, terms[:-1], every, variance=ones)
    start = evaluate(terms[-1].candidate, terms[-1].values, rest)
    return result if start is None else min(result, left(as_term(polish(start, rest))))


def _told_by(found: Diagnosis, favourite: Fitted, recordings: Sequence[Prepared]) -> Problem:
    """Recordings without noise, whose torque is that of a model."""
    model = predictor(favourite)
    told = tuple(dataclasses.replace(p, torque=model.torque(p)) for p in recordings)
    own = favourite.problem.rows.rows
    scales = own.scales if len(told) == len(own.scales) else own.scales[:1] * len(told)
    rows = WhiteRows.of(weigh(told, own.noise, _dry_friction(found.before), scales))
    nothing = np.zeros((rows.joints, rows.torque.shape[1], 0))
    return dataclasses.replace(favourite.problem, rows=rows, nuisances=nothing, means=None)


def _dry_friction(before: Predictor) -> np.ndarray:
    """(n,) height of each joint's friction step [N m]."""
    heights = np.zeros(before.model.robot.n)
    for _, column, sign in sign_terms(before.model):
        heights[sign.joint] = abs(before.parameters[column])
    return heights
