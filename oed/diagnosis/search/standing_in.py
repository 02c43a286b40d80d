"""Free-form terms that stand in for what has no name."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from oed.diagnosis.search.judgement import Accepted, Refused, held_out_fault, judge
from oed.diagnosis.search.ranking import ranked
from oed.diagnosis.search.scan import Score
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.free_form import FreeForm
from oed.diagnosis.terms.restraint import restrained
from oed.diagnosis.terms.trials import Trial, free_form_trials

# Ratio of the held-out error that a free-form term must reach: it knows nothing of physics that
# would carry it to the next motion.
BETTER = 0.95
RIVAL_SHARE = 0.7  # of the best term's gain, from which on another may be the one that is meant
HALVINGS = 4  # of the pieces of a term, one coordinate at a time
WORTH = 0.98  # ratio by which a halving must lower the held-out error to be followed by another
MOST_FUNCTIONS = 400


def next_free_form(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> Accepted | None:
    """The best term that passes all tests, with what of it may predict; None if none does."""
    others = [a.trial for a in accepted]
    standing = [a.trial for a in accepted if a.stands_in]
    pool = (*shop.smooth, *shop.smooth_pairs)
    candidates = [
        c
        for c in ranked(shop, pool, others, shop.settings.refined)
        if c.evidence(shop.full.rows.count) > shop.settings.free_form_margin
    ]
    for candidate in _most_telling_first(shop, candidates, standing):
        passed = judge(shop, candidate, accepted, pool, refused)
        if passed is not None:
            return _standing_in(shop, passed, standing)
    return None


def _most_telling_first(
    shop: Workshop, candidates: list[Score], standing: Sequence[Trial]
) -> list[Score]:
    """Terms that explain about as much as the best, in the order of what they predict.

    On one motion many pairs of coordinates trace out much the same curve: what a function of
    the wrong ones explains there, it does not on another.
    """
    if not candidates:
        return []
    best = candidates[0]
    rivals = [
        c
        for c in candidates
        if c.trial.joint == best.trial.joint
        and c.trial.between_repetitions == best.trial.between_repetitions
        and c.gain > RIVAL_SHARE * best.gain
    ]
    bench = _Bench(shop, standing, best.trial)
    order = sorted(rivals, key=lambda c: min((x.ratio for x in bench.tried([c.trial])), default=1))
    return [*order, *(c for c in candidates if all(c is not r for r in rivals))]


def _standing_in(shop: Workshop, item: Accepted, others: Sequence[Trial]) -> Accepted:
    """A free-form term as far as the data determine it, part of the model if it then predicts."""
    bench = _Bench(shop, others, item.trial)
    tried = bench.tried([item.trial, *_alike(shop, item.trial)])
    # What was noticed may be finer than what noticed it.
    best = tried[:1]
    for _ in range(HALVINGS if best else 0):
        finer = bench.tried(_halved(shop, best[0].whole))
        tried += finer
        if not finer or finer[0].ratio > WORTH * best[0].ratio:
            break
        best = finer
    for choice in sorted(tried, key=lambda c: c.ratio):
        if choice.ratio >= BETTER:
            break
        if held_out_fault(shop, others, choice.trial) is None:
            return dataclasses.replace(item, trial=choice.trial, stands_in=True)
    return dataclasses.replace(item, stands_in=False)


@dataclass(frozen=True)
class _Choice:
    """A term, what of it the data determine, and the ratio of the validation error with it."""

    whole: Trial
    trial: Trial
    ratio: float


class _Bench:
    """Where the restraints of a term are compared on the validation recordings."""

    def __init__(self, shop: Workshop, others: Sequence[Trial], trial: Trial) -> None:
        self._shop, self._others, self._layout = shop, others, shop.layout(trial)
        self._fit = shop.fit(others, self._layout)
        self._joint = next(iter(trial.group))
        self._plain = shop.validation_rms(self._fit)
        self._size = shop.size_of_residual(self._fit, self._joint)

    def tried(self, terms: Sequence[Trial]) -> list[_Choice]:
        """Every restraint of every term, the best first."""
        choices = [
            _Choice(whole, trial, self._ratio(trial))
            for whole in terms
            for trial in restrained(whole, self._fit.fit, self._size)
        ]
        return sorted(choices, key=lambda c: c.ratio)

    def _ratio(self, trial: Trial) -> float:
        if self._plain is None:
            return 0.0
        found = self._shop.fit([*self._others, trial], self._layout, bend=False)
        rms = self._shop.validation_rms(found)
        assert rms is not None  # noqa: S101  # there are validation recordings
        return float(rms[self._joint] / self._plain[self._joint])


def _alike(shop: Workshop, trial: Trial) -> list[Trial]:
    """Other terms of the same joint in the same coordinates: one may carry over better."""
    return [
        t
        for t in (*shop.smooth, *shop.smooth_pairs)
        if t.key != trial.key
        and t.joint == trial.joint
        and t.between_repetitions == trial.between_repetitions
        and set(t.effect.depends_on) == set(trial.effect.depends_on)
    ]


def _halved(shop: Workshop, trial: Trial) -> list[Trial]:
    """The term with pieces half as long, in one of its coordinates at a time."""
    effect = trial.effect
    if not isinstance(effect, FreeForm):
        return []
    terms = []
    for k, coordinate in enumerate(effect.coordinates):
        finer = coordinate.halved()
        parts = (*effect.coordinates[:k], finer, *effect.coordinates[k + 1 :])
        term = dataclasses.replace(effect, coordinates=parts)
        if finer != coordinate and len(term.parameters) <= MOST_FUNCTIONS:
            terms.append(term)
    return free_form_trials(terms, shop.layout(trial).rows, contrast=trial.contrast)
