"""Free-form terms that stand in for what has no name."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted, Refused, refusal
from oed.diagnosis.candidates.chance import chance_of_slow_noise
from oed.diagnosis.candidates.judgement import held_out_fault, judge
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.telling import RIVAL_SHARE
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.restraint import restrained
from oed.diagnosis.terms.scores import Score, score
from oed.diagnosis.terms.trials import Trial, free_form_trials
from oed.dynamics.effects import State
from oed.dynamics.effects.arguments import Factor
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import FreeForm
from oed.dynamics.effects.visited import Visited
from oed.parallel_map import one_by_one, side_by_side

# Ratio of the held-out error that a free-form term must reach: it knows nothing of physics that
# would carry it to the next motion.
BETTER = 0.95
CLEARLY_BETTER = 0.8  # slow noise seldom follows a curve that far, in two motions
FORETOLD = 0.03  # chance of slow noise up to which a ratio between the two is believed
# Pieces of a term that stands in, by the number of its coordinates: what was noticed may be
# finer than what noticed it, and how fine the data say themselves.
PIECES = {1: 36, 2: 10}
# Distances over which a function of two coordinates ends beyond the region that was visited, in
# ranges. One of a single coordinate carries on: there is little beyond its edge.
FADINGS = (0.4, 0.2, 0.1)
AS_MUCH = 0.99  # share of a gain, but for chance: a curve has many columns for what is a line
ENDING = 0.95  # ratio of validation errors from which on it is believed to end


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

    def judged(candidate: Score) -> tuple[Accepted | None, list[Refused]]:
        reasons: list[Refused] = []
        return judge(shop, candidate, accepted, pool, reasons), reasons

    order = _least_left_first(shop, candidates, others, standing)
    for candidate, (passed, reasons) in zip(order, one_by_one(judged, order), strict=True):
        refused += reasons
        if passed is None:
            continue
        found, ratio = _standing_in(shop, passed, standing)
        if shop.mean is not shop.full or ratio < CLEARLY_BETTER:
            return found
        # Neither repetitions nor another motion say clearly that it is the arm's doing. A share
        # of another torque holds on any motion, if it is one.
        chance = chance_of_slow_noise(shop, candidate, others, pool)
        known = found.stands_in or not found.trial.is_share
        if known and chance <= (FORETOLD if found.stands_in else shop.settings.level):
            return found
        reason = f"p = {chance:.2g} in noise that changes as slowly, and unseen motion says no more"
        refused.append(refusal(candidate, reason))
    return None


def _least_left_first(
    shop: Workshop, candidates: list[Score], others: Sequence[Trial], standing: Sequence[Trial]
) -> list[Score]:
    """Terms that explain about as much as the best, in the order of what they leave everywhere.

    On one motion many pairs of coordinates trace out much the same curve: what a function of
    the wrong ones explains there, it does not on another. But one of fewer coordinates with as
    much evidence, or as much of a gain, is preferred in any case: how the other carries on beyond
    them is an accident.
    """
    if not candidates:
        return []
    best, rows = candidates[0], shop.full.rows.count
    rivals = [
        c
        for c in {c.trial.key: c for c in (*candidates, *_shares(shop, best, others))}.values()
        if c.trial.joint == best.trial.joint
        and c.trial.between_repetitions == best.trial.between_repetitions
        and c.gain > RIVAL_SHARE * best.gain
    ]
    rivals = [
        c
        for c in rivals
        if not any(
            _is_within(r, c)
            and (
                r.evidence(rows) >= c.evidence(rows)
                or r.gain >= AS_MUCH * c.gain - shop.settings.decisive
            )
            for r in rivals
        )
    ]
    bench = _Bench(shop, standing, best.trial)

    def left(candidate: Score) -> float:
        tried = bench.tried(_with_fine_pieces(shop, [candidate.trial], crowded=False))
        return min((choice.left for choice in tried), default=np.inf)

    lefts = side_by_side(left, rivals)
    order = [rivals[k] for k in np.argsort(lefts, kind="stable")]
    tried = {r.trial.key for r in rivals}
    return [*order, *(c for c in candidates if c.trial.key not in tried)]


def _is_within(one: Score, other: Score) -> bool:
    """Whether the coordinates of one term are some of another's."""
    return set(one.trial.effect.depends_on) < set(other.trial.effect.depends_on)


def _shares(shop: Workshop, best: Score, others: Sequence[Trial]) -> list[Score]:
    """Shares of other joints' torques in that of a joint, which a curve of the best may copy."""
    fit = shop.fit(others, shop.mean).fit
    own = (t for t in shop.smooth if t.is_share and t.joint == best.trial.joint)
    return [score(t, fit) for t in own]


def _standing_in(shop: Workshop, item: Accepted, others: Sequence[Trial]) -> tuple[Accepted, float]:
    """A free-form term as far as the data determine it, part of the model if it then predicts.

    With the ratio of the validation error, 1 where it does not.
    """
    if not shop.validation:  # where nothing is foretold, nothing foretells it better
        return dataclasses.replace(item, stands_in=False), 1.0
    bench = _Bench(shop, others, item.trial)
    tried = bench.tried(
        _with_fine_pieces(shop, [item.trial, *_alike(shop, item.trial)]), ending=True
    )
    better = [choice for choice in tried if choice.ratio < BETTER]
    faults = one_by_one(lambda choice: held_out_fault(shop, others, choice.trial), better)
    for choice, fault in zip(better, faults, strict=True):
        if fault is None:
            return dataclasses.replace(item, trial=choice.trial, stands_in=True), choice.ratio
    return dataclasses.replace(item, stands_in=False), 1.0


@dataclass(frozen=True)
class _Choice:
    """What of a term the data determine.

    Attributes:
        trial: With these combinations as its columns.
        ratio: Of the validation error with it to that without.
        left: Squares that it leaves of the estimation rows and of the validation error, each
            over those without it, added.
    """

    trial: Trial
    ratio: float
    left: float


class _Bench:
    """Where the restraints of a term are compared on the validation recordings."""

    def __init__(self, shop: Workshop, others: Sequence[Trial], trial: Trial) -> None:
        self._shop, self._others, self._layout = shop, others, shop.layout(trial)
        self._fit = shop.fit(others, self._layout)
        self._joint = next(iter(trial.group))
        # A curve that claims no physics has to foretell as it is.
        self._plain, _ = shop.foretold(others, [*others, trial], as_it_is=True)
        self._visited: dict[str, Visited] = {}

    def tried(self, terms: Sequence[Trial], *, ending: bool = False) -> list[_Choice]:
        """Every restraint of every term, the best first.

        Args:
            terms: With all their combinations.
            ending: Whether they may also end beyond the visited region.
        """
        fadings = FADINGS if ending else ()

        def judged(whole: Trial) -> list[_Choice]:
            own = restrained(whole, self._fit.fit)
            return [choice for trial in own for choice in self._judged(trial, fadings)]

        choices = [choice for found in side_by_side(judged, terms) for choice in found]
        return sorted(choices, key=lambda c: c.ratio)

    def _judged(self, trial: Trial, fadings: Sequence[float]) -> Iterator[_Choice]:
        chosen = [*self._others, trial]
        before, after = (
            float(np.sum(f.fit.residual[self._joint] ** 2))
            for f in (self._fit, self._shop.fit(chosen, self._layout, bend=False))
        )
        found = self._shop.fit(chosen, bend=False)
        plain = self._ratio(found)
        yield _Choice(trial, plain, after / before + plain**2)
        for own in self._ending(trial, fadings):
            # In the region it is the same: one fit serves all.
            ratio = self._ratio(dataclasses.replace(found, chosen=(*found.chosen[:-1], own)))
            if ratio < ENDING * plain:
                yield _Choice(own, ratio, after / before + ratio**2)

    def _ratio(self, found: Augmented) -> float:
        rms = self._shop.validation_rms(found, as_it_is=True)
        if self._plain is None or rms is None:
            return 1.0
        return float(rms[self._joint] / self._plain[self._joint])

    def _ending(self, trial: Trial, fadings: Sequence[float]) -> Iterator[Trial]:
        effect = trial.effect
        if not isinstance(effect, FreeForm) or not self._shop.validation:
            return
        if sum(isinstance(c, Coordinate) and c.kind != "time" for c in effect.coordinates) < 2:
            return
        if effect.label not in self._visited:
            states = [State.along(p.motion, 0.0) for p in self._shop.full.rows.prepared]
            places = np.concatenate([effect.places(state) for state in states])
            self._visited[effect.label] = Visited.of(places, FADINGS[0])
        for fading in fadings:
            visited = dataclasses.replace(self._visited[effect.label], fading=fading)
            yield dataclasses.replace(trial, effect=dataclasses.replace(effect, visited=visited))


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


def _with_fine_pieces(
    shop: Workshop, trials: Sequence[Trial], *, crowded: bool = True
) -> list[Trial]:
    """Terms with fine pieces, those over a speed once more with pieces that crowd about zero."""
    terms = []
    for effect in (t.effect for t in trials):
        if not isinstance(effect, FreeForm):
            continue
        count = sum(not isinstance(c, Factor) for c in effect.coordinates)
        fine = tuple(c.refined(PIECES[count]) for c in effect.coordinates)
        denser = tuple(
            c.crowded() if isinstance(c, Coordinate) and c.kind == "dq" else c for c in fine
        )
        kinds = dict.fromkeys((fine, denser) if crowded else (fine,))
        terms += [dataclasses.replace(effect, coordinates=c) for c in kinds]
    first = trials[0]
    return free_form_trials(terms, shop.layout(first).rows, contrast=first.contrast)
