"""Shapes and formulas of a candidate, improved from where a scan found it."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import minimize

from oed.diagnosis.terms.scores import Score, Worth, gain_of, implausible, is_better, score
from oed.diagnosis.terms.trials import Trial, catalogue_trial, moved
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.catalogue import CATALOGUE, Context

# Fall of -2 log likelihood, in noise that is as stated, by which a shape may miss its best value:
# a tenth of a standard deviation.
AT_REST = 0.01
MOST_ROUNDS = 12
FORMULA = 6.0  # evidence by which a formula of more terms must exceed a plainer one


def refine(found: Score, fit: LinearFit, context: Context, worth: Worth = gain_of) -> Score:
    """The shape of a candidate improved from the scan's best grid point, and its formula there.

    A formula of more terms must explain so much more that the evidence asks for them.
    """

    def evidence(tried: Score) -> float:
        return worth(tried) - tried.price(fit.rows.count)

    best = climb(found, fit, context, worth)
    for start in other_formulas(best, fit, context):
        tried = climb(start, fit, context, worth)
        more = evidence(tried) - evidence(best)
        margin = -FORMULA if tried.freedom < best.freedom else FORMULA
        if more > margin and is_better(tried, best, context, more=True):
            best = tried
    return best


def other_formulas(found: Score, fit: LinearFit, context: Context) -> Iterator[Score]:
    """A candidate with all other terms that its equation may have."""
    if found.trial.is_free_form:
        return
    shapes = CATALOGUE[found.trial.name].shapes_for(context, found.trial.target)
    for place, shape in enumerate(shapes):
        for value in range(round(shape.lower), round(shape.upper) + 1):
            if shape.scale == "formula" and value != found.trial.values[place]:
                values = (
                    *found.trial.values[:place],
                    float(value),
                    *found.trial.values[place + 1 :],
                )
                there = dataclasses.replace(found.trial, values=values)
                yield score(moved(there, fit.rows, context, contrast=there.contrast), fit)


def shorter_formulas(found: Score, fit: LinearFit, context: Context) -> list[Score]:
    """A candidate by those of its formulas that have fewer terms."""
    terms = len(found.coefficients)
    return [s for s in other_formulas(found, fit, context) if len(s.coefficients) < terms]


def climb(
    found: Score,
    fit: LinearFit,
    context: Context,
    worth: Worth = gain_of,
    *,
    held: int | None = None,
) -> Score:
    """Improve the shape of a candidate, its formula as it is (Nelder and Mead).

    Args:
        found: Candidate.
        fit: Beside which.
        context: What is known.
        worth: What is to be large.
        held: Place of a shape that stays as it is; None if all may move.
    """
    if not found.trial.shapes:
        return found
    shapes = CATALOGUE[found.trial.name].shapes_for(context, found.trial.target)
    best, most, fault = found, worth(found), implausible(found, context)
    whole = np.array([s.place_of(v) for v, s in zip(found.trial.values, shapes, strict=True)])
    # A choice between whole numbers that has but one trial value is not for these data to make.
    free = np.array(
        [
            (s.is_estimated or (s.scale == "choice" and s.points > 1))
            and not s.is_idle(v)
            and place != held
            for place, (v, s) in enumerate(zip(found.trial.values, shapes, strict=True))
        ]
    )
    if not free.any():
        return found
    # From a plausible start on, what is not plausible explains nothing.
    guarded = fault is None

    def loss(x: Float[ndarray, " shapes"]) -> float:
        nonlocal best, most, fault
        whole[free] = x
        tried = score_at(whole, found.trial, fit, context)
        value = worth(tried)
        wrong = implausible(tried, context)
        # A plausible shape before one that explains more.
        if (wrong is None, value) > (fault is None, most):
            best, most, fault = tried, value, wrong
        return np.inf if guarded and wrong is not None else -value

    start = whole[free]
    steps = np.array([0.6 / max(s.points - 1, 1) for s in shapes])[free]
    inward = np.where(start + steps > 1, -steps, steps)
    simplex = np.vstack([start, start + np.diag(inward)])
    minimize(
        loss,
        start,
        method="Nelder-Mead",
        options={
            "initial_simplex": simplex,
            "maxfev": 20 + 15 * len(start),
            "xatol": 1e-3,
            "fatol": AT_REST,
        },
    )
    return best


def score_at(
    axes: Float[ndarray, " shapes"], trial: Trial, fit: LinearFit, context: Context
) -> Score:
    """A candidate with other shapes.

    Args:
        axes: Shapes, each from 0 to 1 over its range.
        trial: The candidate.
        fit: Beside which.
        context: What is known.
    """
    entry = CATALOGUE[trial.name]
    shapes = entry.shapes_for(context, trial.target)
    values = tuple(
        value if shape.is_idle(value) else shape.at(float(x))
        for x, shape, value in zip(axes, shapes, trial.values, strict=True)
    )
    tried = catalogue_trial(entry, context, trial.target, values, fit.rows, contrast=trial.contrast)
    return score(tried, fit)


def at_rest(found: Score, fit: LinearFit, context: Context, worth: Worth = gain_of) -> Score:
    """The shape of a candidate refined until another round of it gains nothing that matters.

    Where shapes trade places, a simplex shrinks in the valley before it has followed it, or at
    the bound where it began; started anew it goes on.
    """
    best = found
    for _ in range(MOST_ROUNDS):
        again = refine(best, fit, context, worth)
        if again.freedom < best.freedom:  # terms of its formula that the data do not ask for
            best = again
            continue
        gained = worth(again) - worth(best)
        settled = gained < AT_REST
        best = again if is_better(again, best, context, more=gained > 0) else best
        if settled:
            break
    return best
