"""What may honestly be said: found effects with their evidence, rivals, and what has no name."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from oed.diagnosis.candidates.chance import p_value_of
from oed.diagnosis.candidates.leftovers import is_own
from oed.diagnosis.candidates.margin import CLOSE, is_first_order, is_of_kind
from oed.diagnosis.candidates.paying import validation_gain
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.evidence.contenders import Rival, find_rivals
from oed.diagnosis.evidence.estimates import Estimated, estimates
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.tilt_review import stood_upright, validation_gain_of_tilt
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import score
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.motor import CrossCoupling, MotorCoupling
from oed.dynamics.effects.smooth_term import FreeForm
from oed.parallel_map import side_by_side

Outcome = Literal["nothing found", "explained", "ambiguous", "unexplained"]


@dataclass(frozen=True)
class FoundEffect:
    """An effect that the data carry.

    Attributes:
        name: Of the catalogue.
        joint: Index, None for the whole arm.
        parameters: Coefficients and shapes.
        p_value: That chance explains as much beside all other additions, the whole search counted.
        validation_gain: Share by which it lowers the validation rms of its joints; None
            without validation recordings.
        rivals: What else could have been named.
        trial: Its columns.
    """

    name: str
    joint: int | None
    parameters: tuple[Estimated, ...]
    p_value: float
    validation_gain: float | None
    rivals: tuple[Rival, ...]
    trial: Trial


@dataclass(frozen=True)
class Unexplained:
    """Something that is there and has no name.

    Attributes:
        joint: Index.
        depends_on: Coordinates that it depends on; empty where none is known.
        share: Of the joint's residual variance (before any addition) that it carries; of what
            repetitions differ by, or a single motion leaves, where it keeps its own time; of the
            error's square where no coordinate is known.
        label: What it is, in words.
        stands_in: Whether the free-form term is part of the augmented model.
        trial: Its columns; None where it has none.
    """

    joint: int
    depends_on: tuple[str, ...]
    share: float
    label: str
    stands_in: bool
    trial: Trial | None = None


def describe_effects(
    shop: Workshop, selection: Selection, whole: Augmented
) -> tuple[FoundEffect, ...]:
    """Every named effect with parameters, evidence and rivals.

    Args:
        shop: The laid-out data.
        selection: What was added.
        whole: Its fit, with the uncertainty of its parameters.
    """

    def described(place: int) -> FoundEffect:
        trial = whole.chosen[place]
        own = next(a for a in selection.accepted if a.trial.key == trial.key)
        others = [t for t in selection.trials if t.key != trial.key and not mends(t, trial)]
        return FoundEffect(
            name=trial.name,
            joint=trial.joint,
            parameters=estimates(shop, trial, whole.coefficients[place], whole.covariances[place]),
            p_value=_chance(shop, trial, others),
            validation_gain=(
                validation_gain_of_tilt(shop, others)
                if trial.name == GRAVITY and shop.is_turned
                else validation_gain(shop, [*others, trial], trial, as_it_is=True)
            ),
            rivals=find_rivals(shop, own, others),
            trial=trial,
        )

    named = [k for k, trial in enumerate(whole.chosen) if not trial.is_free_form]
    found = side_by_side(described, named)
    # Of what comes back, the tables know the effects themselves by their identity.
    return tuple(
        dataclasses.replace(effect, trial=whole.chosen[k])
        for effect, k in zip(found, named, strict=True)
    )


def _chance(shop: Workshop, trial: Trial, others: Sequence[Trial]) -> float:
    """Of as much by accident, beside the others; of a tilt on tables that stand as declared."""
    if trial.name == GRAVITY and shop.is_turned:
        shop, others = stood_upright(shop, others)
    own = shop.renewed(trial)
    found = score(own, shop.fit(others, shop.layout(own)).fit)
    return p_value_of(shop, found, others, shop.physical)


def preferred_rival(
    effects: Sequence[FoundEffect],
    decisive: float,
    barred: Collection[tuple[str, object]],
    ended: Collection[tuple[str, object]] = (),
) -> tuple[Trial, Trial] | None:
    """A name, and the rival that the data prefer by far beside all others.

    The search took the name when the others were not yet there. The rival has fewer parameters, for
    more would find something else that is missing; but another of its kind finds no other, and of
    two laws of one kind the data's own choice is named. Of one at the end of what its name says, any
    rival within the evidence is preferred; of a coupling that is the same from either joint, the
    one by which it is named.

    Args:
        effects: With their rivals.
        decisive: Difference of evidence that separates two.
        barred: Keys that may not come back.
        ended: Keys of names at their end.
    """
    taken = {*barred} | {e.trial.key for e in effects}
    for effect in effects:
        for rival in effect.rivals:
            if rival.trial.key in taken:
                continue
            if rival.evidence < decisive and _is_meant(rival.trial, effect.trial):
                return effect.trial, rival.trial
            if not rival.contender:
                continue
            plainer = rival.trial.freedom < effect.trial.freedom
            nested = is_first_order(rival.trial, effect.trial)
            margin = rival.margin if nested else CLOSE
            if (
                effect.trial.key in ended
                or (plainer and rival.evidence < -decisive)
                or (is_of_kind(rival.trial, effect.trial) and rival.evidence < -margin)
            ):
                return effect.trial, rival.trial
    return None


def _is_meant(mirror: Trial, trial: Trial) -> bool:
    """Whether a coupling is named by the other of its joints.

    An inertia in both rows by the inner one; a motor that may be either's by the outer one.
    """
    own, its = trial.target, mirror.target
    if mirror.name != trial.name or not isinstance(own, tuple) or its != own[::-1]:
        return False
    alike = type(mirror.effect) is type(trial.effect)
    if isinstance(trial.effect, CrossCoupling):
        return alike and own[0] > own[1]
    if isinstance(trial.effect, MotorCoupling):
        return alike and own[0] < own[1]
    return False


def outdone(effects: Sequence[FoundEffect], decisive: float) -> Trial | None:
    """A name of which the data prefer a rival of another kind by far.

    Where something has no name, both may follow a part of it, and neither is what is there.
    """
    for effect in effects:
        for rival in effect.rivals:
            if (
                rival.contender
                and rival.evidence < -decisive
                and not is_of_kind(rival.trial, effect.trial)
            ):
                return effect.trial
    return None


def outdone_by_tilt(
    effects: Sequence[FoundEffect], decisive: float
) -> frozenset[tuple[str, object]]:
    """Keys of names in whose place a base that is not level tells more by far."""
    return frozenset(
        effect.trial.key
        for effect in effects
        for rival in effect.rivals
        if rival.contender and rival.name == GRAVITY and rival.evidence < -decisive
    )


def describe_unexplained(shop: Workshop, selection: Selection) -> tuple[Unexplained, ...]:
    """Free-form terms that the data demand, with the share of the residual that they carry."""
    result = []
    for item in selection.accepted:
        effect = item.trial.effect
        if not isinstance(effect, FreeForm):
            continue
        residual = shop.fit((), shop.layout(item.trial)).fit.residual[effect.joint]
        share = min(1.0, item.gain / float(np.sum(residual**2)))
        result.append(
            Unexplained(
                effect.joint, effect.depends_on, share, effect.label, item.stands_in, item.trial
            )
        )
    return tuple(result)


def riddles(
    effects: Sequence[FoundEffect], unexplained: Sequence[Unexplained]
) -> tuple[Unexplained, ...]:
    """What has no name, but for free-form terms that mend the formula of a named effect."""
    return tuple(
        u
        for u in unexplained
        if u.trial is None or not any(mends(u.trial, e.trial) for e in effects)
    )


def decide(effects: Sequence[FoundEffect], unexplained: Sequence[Unexplained]) -> Outcome:
    """The verdict in the interface's words."""
    if any(r.contender for e in effects for r in e.rivals):
        return "ambiguous"
    if riddles(effects, unexplained):
        return "unexplained"
    return "explained" if effects else "nothing found"


def mends(other: Trial, trial: Trial) -> bool:
    """Whether another addition is a freer form of an effect."""
    return other.joint == trial.joint and is_own(other, trial)
