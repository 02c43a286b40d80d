"""Scores of all trials beside a model, and how large they are by chance alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.special import chdtrc, gammaln

from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.addition import (
    NormalEquations,
    normal_equations,
    normal_equations_of_all,
)
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.catalogue import CATALOGUE, Context

FREE_FORM_RIDGE = 1e-3  # of a unit column's square


@dataclass(frozen=True)
class Score:
    """What a trial would add to a model.

    Attributes:
        trial: The effect with its shape.
        gain: Fall of the whitened sum of squares.
        freedom: Parameters that it costs, shapes included.
        coefficients: Of its columns.
        cancelled: Its own squares over its gain: large where it trades places with the model,
            and explains by the difference of two large torques.
        promise: What it would gain if its size were free: a fixed size that is wrong, or wrong
            only because another shape is, makes an error of what points the right way.
    """

    trial: Trial
    gain: float
    freedom: int
    coefficients: Float[ndarray, " columns"]
    cancelled: float = 1.0
    promise: float = 0.0

    def evidence(self, rows: int) -> float:
        """Gain less its price.

        Half of it is the change of log evidence, with a prior that expects an effect's torque
        to be of the size of what it explains.
        """
        return self.gain - self.price(rows)

    def price(self, rows: int) -> float:
        """Schwarz's penalty, and Occam's factor of a size far beyond what it explains."""
        linear = 0 if self.trial.is_free_form else len(self.coefficients)
        occam = linear * np.log(max(self.cancelled, 1.0))
        return float(self.freedom * np.log(rows) + occam)

    def surprise(self, inflation: Float[ndarray, " joints"]) -> float:
        """-log of the chance of this gain in noise that large, shapes counted as parameters."""
        gains = np.array([max(self.gain, 0.0) / inflation[list(self.trial.group)].mean()])
        return float(minus_log_chance(gains, max(self.freedom, 1))[0])


Worth = Callable[[Score], float]


def gain_of(found: Score) -> float:
    """What a shape is chosen by, unless noise has a share in it."""
    return found.gain


def minus_log_chance(gains: Float[ndarray, " count"], freedom: int) -> Float[ndarray, " count"]:
    """-log of a chi-square's upper tail, by its leading terms where it underflows."""
    exact = -np.log(chdtrc(freedom, np.clip(gains, 0.0, 400.0)))
    half = np.maximum(gains, 1.0) / 2
    leading = half - (freedom / 2 - 1) * np.log(half) + gammaln(freedom / 2)
    return np.where(gains > 400.0, leading, exact)


def inflation_of(fit: LinearFit) -> Float[ndarray, " joints"]:
    """(n,) mean squared white residual where it exceeds one: what the model lacks is noise too."""
    return np.maximum(1.0, np.sum(fit.residual**2, axis=1) / fit.freedom())


def score(trial: Trial, fit: LinearFit) -> Score:
    """Judge one trial beside a model."""
    normal = normal_equations(fit.projection, fit.residual, trial.group)
    return _scored([trial], normal.in_a_row())[0]


def scores(trials: Sequence[Trial], fit: LinearFit) -> list[Score]:
    """The same of many, at a fraction of the time."""
    groups, grams = [t.group for t in trials], [t.gram for t in trials]
    found: dict[int, Score] = {}
    for places, normal in normal_equations_of_all(fit.projection, fit.residual, groups, grams):
        found |= zip(places, _scored([trials[k] for k in places], normal), strict=True)
    return [found[k] for k in range(len(trials))]


def _scored(trials: Sequence[Trial], normal: NormalEquations) -> list[Score]:
    """Scores of trials of as many columns, by the normal equations of each."""
    found: dict[int, Score] = {}
    if fixed := [k for k, trial in enumerate(trials) if trial.fixed]:
        found |= zip(
            fixed, _as_they_are([trials[k] for k in fixed], normal.some(fixed)), strict=True
        )
    if free := [k for k in range(len(trials)) if k not in found]:
        own = [trials[k] for k in free]
        found |= zip(free, _by_free_size(own, normal.some(free)), strict=True)
    return [found[k] for k in range(len(trials))]


def _as_they_are(trials: Sequence[Trial], normal: NormalEquations) -> Iterator[Score]:
    """Of trials whose coefficients are one."""
    numbers = zip(
        normal.moment.sum(axis=1).tolist(),
        normal.gram.sum(axis=(1, 2)).tolist(),
        np.trace(normal.gram, axis1=1, axis2=2).tolist(),
        normal.lengths.sum(axis=1).tolist(),
        strict=True,
    )
    ones = np.ones(normal.lengths.shape[1])
    for trial, (towards, size, outside, whole) in zip(trials, numbers, strict=True):
        if outside < 1e-6 * whole:  # the model has it all
            yield Score(trial, 0.0, trial.shapes, ones)
        else:
            promise = max(towards, 0.0) ** 2 / size
            yield Score(trial, 2 * towards - size, trial.shapes, ones, promise=promise)


def _by_free_size(trials: Sequence[Trial], normal: NormalEquations) -> Iterator[Score]:
    solved = normal.each_solved(np.array([ridge_of(t) for t in trials]))
    for trial, found in zip(trials, solved, strict=True):
        freedom = found.rank + trial.shapes if found.rank else 0
        cancelled = found.squares / found.gain if found.gain > 0 else 1.0
        # Its size is free as it is.
        yield Score(trial, found.gain, freedom, found.coefficients, cancelled, promise=found.gain)


def none_explains_more(
    trials: Iterable[Trial], fit: LinearFit, gain: float, joints: Sequence[int]
) -> bool:
    """Whether no trial gains more beside a model, but for what its parameters gain in noise.

    Args:
        trials: Candidates.
        fit: Beside which.
        gain: What they are held against.
        joints: Whose noise counts.
    """
    noise = float(inflation_of(fit)[list(joints)].mean())
    found = (score(t, fit) for t in trials)
    return all(s.gain - s.freedom * noise < gain for s in found)


def ridge_of(trial: Trial) -> float:
    """Of a unit column's square, that keeps a free form's coefficients bounded."""
    return FREE_FORM_RIDGE if trial.is_free_form else 0.0


def scan(trials: Sequence[Trial], fit: LinearFit, context: Context) -> list[Score]:
    """The best plausible shape of every candidate, or its best one; largest surprise first."""
    return best_shapes(scores(trials, fit), fit, context)


def best_shapes(judged: Sequence[Score], fit: LinearFit, context: Context) -> list[Score]:
    """The same of trials that have their scores."""
    by_key: dict[tuple[str, object], list[Score]] = {}
    for found in judged:
        by_key.setdefault(found.trial.key, []).append(found)
    best = []
    for own in by_key.values():
        own.sort(key=lambda s: -s.gain)
        best.append(next((s for s in own if implausible(s, context) is None), own[0]))
    inflation = inflation_of(fit)
    return sorted(best, key=lambda s: -s.surprise(inflation))


def implausible(found: Score, context: Context) -> str | None:
    """Why the estimates of a candidate cannot be what its name says; None if they can."""
    trial = found.trial
    if trial.is_free_form:
        return None
    entry = CATALOGUE[trial.name]
    return entry.plausible(context, trial.target, trial.values, found.coefficients)


def is_better(new: Score, old: Score, context: Context, *, more: bool) -> bool:
    """A plausible shape before one that explains more."""
    if more:
        return implausible(new, context) is None or implausible(old, context) is not None
    return implausible(old, context) is not None and implausible(new, context) is None
