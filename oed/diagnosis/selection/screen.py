"""A score test of every candidate over a grid of its shapes, and the best of them polished."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import minimize, minimize_scalar

from oed.diagnosis.candidates.candidate import Candidate, Values
from oed.diagnosis.evidence.columns import white_effect
from oed.diagnosis.evidence.criterion import Moments, Worth, log_score, worth
from oed.diagnosis.evidence.fit import Beside
from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.numbers import FORMULA_ERROR, OUTSIDE, SMOOTHNESS
from oed.diagnosis.problem import Problem
from oed.dynamics.effects.entry import AT_AN_END

NEW = 1e-6  # share of columns outside the model's, below which they add nothing
EVALUATIONS = 25  # of a shape, and so many more for each further one
ROUGH = 6  # of these, to tell which candidates are worth all of them


@dataclass(frozen=True, eq=False)
class Scored:
    """A candidate at some shapes beside a fit.

    Attributes:
        candidate: What.
        values: Its shapes.
        worth: What it is worth there.
    """

    candidate: Candidate
    values: Values
    worth: Worth

    @property
    def nats(self) -> float:
        """Of its worth."""
        return self.worth.nats


def price(candidate: Candidate, values: Values, fitted: Fitted, rows: float) -> float:
    """-log prior probability of a candidate with these shapes [nats].

    All of a kind are alike before data; a shape that is not at its plain value costs half the log
    of the rows, or the log of the values that a scan tells apart where these are more.
    """
    total = least_price(candidate, fitted.problem)
    for shape, value in zip(candidate.shapes(fitted.context), values, strict=True):
        if shape.is_plain(value) or shape.is_idle(value) or shape.upper <= shape.lower:
            continue
        if shape.is_estimated:
            count = max(shape.points, shape.fine, 1)
            total += max(0.5 * float(np.log(max(rows, 2.0))), float(np.log(count)))
        elif value != shape.default:
            total += float(np.log(max(shape.upper - shape.lower + 1, 2.0)))
    return total


def least_price(candidate: Candidate, problem: Problem) -> float:
    """Price of a candidate whose shapes are all plain [nats]; of a smooth one each smoothness is alike."""
    if candidate.is_named:
        return float(np.log(max(len(problem.names), 1)))
    return float(np.log(max(len(problem.smooth), 1) * len(SMOOTHNESS) / OUTSIDE))


def most_gained(beside: Beside, counted: Float[ndarray, " joints"]) -> float:
    """Nats of log score that columns cannot exceed: all that they take from what is left is one joint's.

    Args:
        beside: The columns beside a fit, joints weighted by what it leaves of each.
        counted: (n,) rows that count.
    """
    A, g = beside.information, beside.score
    values, vectors = np.linalg.eigh(A)
    told = values > NEW * max(float(values[-1]), 0.0)
    taken = float(np.sum((vectors.T @ g)[told] ** 2 / values[told]))
    rows = float(counted.min())
    return -0.5 * rows * float(np.log1p(-taken / rows)) if taken < rows else np.inf


def weighed(
    candidate: Candidate,
    values: Values,
    fitted: Fitted,
    beside: Beside,
    counted: Float[ndarray, " joints"],
    *,
    dilution: float = 1.0,
    fixed: bool | None = None,
) -> Worth | None:
    """Worth of a candidate's columns beside a fit, by the log score that they would have.

    Args:
        candidate: What.
        values: Its shapes.
        fitted: The model beside which it stands.
        beside: Its columns there.
        counted: (n,) rows that count.
        dilution: Of them that tell as much as one.
        fixed: Whether coefficients are 1; as the candidate has it if None.
    """
    A, g = beside.information, beside.score
    if np.trace(A) <= NEW * sum(float(np.trace(x)) for x in beside.squares.values()):
        return None
    rows = float(sum(counted[j] for j in beside.squares))
    cost = price(candidate, values, fitted, rows)
    penalty = candidate.precision(len(g))
    fixed = candidate.unit_coefficient if fixed is None else fixed
    own = worth(Moments(A, g, rows, dilution), cost, penalty, fixed=fixed)
    before = beside.span.squares / beside.span.weights**2
    after = beside.left_by(own.coefficients)
    tolerated = fitted.tolerated + FORMULA_ERROR**2 * beside.power(own.coefficients) / counted
    gained = log_score(after, counted, tolerated) - log_score(before, counted, tolerated)
    return dataclasses.replace(own, nats=gained / dilution - own.occam - cost)


def promised(
    candidate: Candidate,
    values: Values,
    fitted: Fitted,
    beside: Beside,
    counted: Float[ndarray, " joints"],
) -> Worth | None:
    """What shapes on a grid promise, as a place from which to fit them; None without columns.

    An effect whose size is one of its shapes has no coefficient. Beside the right size it explains
    little or does harm, and yet its direction may be right: it is weighed as if the size were free.
    """
    own = weighed(candidate, values, fitted, beside, counted)
    if own is None or not candidate.unit_coefficient:
        return own
    free = weighed(candidate, values, fitted, beside, counted, fixed=False)
    if free is None or not np.all(free.coefficients > 0):
        return own
    return dataclasses.replace(own, nats=max(own.nats, free.nats))


def evaluate(
    candidate: Candidate, values: Values, fitted: Fitted, dilution: float = 1.0
) -> Scored | None:
    """A candidate at some shapes beside a fit; None where it has no columns or no support.

    Args:
        candidate: What.
        values: Its shapes.
        fitted: The model beside which it stands.
        dilution: Rows that tell as much as one.
    """
    context = fitted.context
    try:
        effect = candidate.effect(context, values)
    except ValueError:
        return None

    columns = white_effect(effect, fitted.installed, fitted.problem.rows)
    if not columns or not all(np.isfinite(c).all() for c in columns.values()):
        return None
    beside = fitted.projection.beside(columns)
    used = fitted.projection.used
    own = weighed(candidate, values, fitted, beside, fitted.rows(used), dilution=dilution)
    if own is None:
        return None
    if candidate.excluded(context, values, own.coefficients) is not None:
        return None
    return Scored(candidate, values, own)


def polish(scored: Scored, fitted: Fitted, *, roughly: bool = False) -> Scored:
    """A candidate with the shapes that are worth most near those given (variable projection).

    Of each formula that it has: where one of them is best, another need not be good.

    Args:
        scored: It, with the shapes to start from.
        fitted: The model beside which it stands.
        roughly: With few evaluations, and without a second scan, which is enough to tell what is
            worth more.
    """
    shapes = scored.candidate.shapes(fitted.context)
    evaluations = ROUGH if roughly else EVALUATIONS
    best = _profiled(scored if roughly else _scanned(scored, fitted), fitted, evaluations)
    for k, shape in enumerate(shapes):
        if shape.scale != "formula":
            continue
        for option in range(int(shape.lower), int(shape.upper) + 1):
            if float(option) == best.values[k]:
                continue
            starts = [
                evaluate(scored.candidate, (*near[:k], float(option), *near[k + 1 :]), fitted)
                for near in dict.fromkeys((scored.values, best.values))
            ]
            known = [start for start in starts if start is not None]
            if known:
                other = _profiled(max(known, key=lambda s: s.nats), fitted, evaluations)
                best = max(best, other, key=lambda s: s.nats)
    return best


def _scanned(scored: Scored, fitted: Fitted) -> Scored:
    """A candidate after a second scan of shapes that need one, as far as the first one's next values."""
    best = scored
    for k, shape in enumerate(scored.candidate.shapes(fitted.context)):
        if shape.fine <= shape.points or shape.is_idle(best.values[k]):
            continue
        middle, reach = shape.place_of(best.values[k]), 1.0 / max(shape.points - 1, 1)
        places = middle + np.arange(-reach, reach, 1.0 / shape.fine)
        values = dict.fromkeys(shape.at(float(x)) for x in places)
        tried = ((*best.values[:k], value, *best.values[k + 1 :]) for value in values)
        found = (evaluate(best.candidate, each, fitted) for each in tried)
        best = max([best, *(s for s in found if s)], key=lambda s: s.nats)
    return best


def _profiled(scored: Scored, fitted: Fitted, evaluations: int) -> Scored:
    """A candidate's formula with the shapes that are worth most near those given."""
    shapes = scored.candidate.shapes(fitted.context)
    best = scored
    free = [
        k
        for k, shape in enumerate(shapes)
        if shape.is_estimated
        and shape.upper > shape.lower
        and not shape.is_idle(best.values[k])
        and shape.lower <= best.values[k] <= shape.upper
    ]
    plain = [k for k in free if shapes[k].is_plain(best.values[k])]
    for moving in ([k for k in free if k not in plain], free if plain else []):
        if moving:
            best = _climbed(best, moving, fitted, evaluations)
    return best


def _climbed(scored: Scored, moving: list[int], fitted: Fitted, evaluations: int) -> Scored:
    shapes = scored.candidate.shapes(fitted.context)
    best = scored

    def at(places: Float[ndarray, " moving"]) -> float:
        nonlocal best
        values = list(scored.values)
        for k, place in zip(moving, places, strict=True):
            values[k] = shapes[k].at(float(place))
        other = evaluate(scored.candidate, tuple(values), fitted)
        if other is None:
            return 1e6
        if other.nats > best.nats:
            best = other
        return -other.nats

    start = np.array([shapes[k].place_of(scored.values[k]) for k in moving])
    steps = np.array([shapes[k].step for k in moving])
    if len(moving) == 1:
        middle, width, least = float(start[0]), float(steps[0]), np.inf
        while True:
            low, high = max(middle - width, 0.0), min(middle + width, 1.0)
            found = minimize_scalar(
                lambda x: at(np.array([x])),
                bounds=(low, high),
                method="bounded",
                options={"maxiter": evaluations, "xatol": 1e-3 * width},
            )
            beyond = (low > 0 and found.x - low < AT_AN_END * width) or (
                high < 1 and high - found.x < AT_AN_END * width
            )
            if not beyond or found.fun >= least:
                return best
            middle, least = float(found.x), found.fun
    simplex = np.stack(
        [
            start,
            *(
                start + np.where(np.arange(len(moving)) == k, _inward(start, steps), 0.0)
                for k in range(len(moving))
            ),
        ]
    )
    minimize(
        at,
        start,
        method="Nelder-Mead",
        options={
            "maxfev": evaluations * len(moving),
            "initial_simplex": np.clip(simplex, 0, 1),
            "xatol": 1e-3,
            "fatol": 0.05,
        },
    )
    return best


def _inward(
    start: Float[ndarray, " moving"], steps: Float[ndarray, " moving"]
) -> Float[ndarray, " moving"]:
    return np.where(start + steps <= 1.0, steps, -steps)
