"""Shapes that one motion leaves open, decided by what another motion does.

A motion that hardly ever goes slowly says that friction rises there, and not how: many shapes
explain as much of it, and foretell very different torques of a motion that does go slowly. The
likelihood of both is that of the first times that of the second, foretold from the first; shapes
are taken where it is largest. The parameters that come linearly are those of the first alone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.ripening import is_late, is_unripe
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import at_rest, climb, shorter_formulas
from oed.diagnosis.terms.scores import Score, implausible, inflation_of, score
from oed.diagnosis.terms.trials import Trial, dense, moved
from oed.dynamics.effects.catalogue import CATALOGUE

CRESTS = 2  # points of the grid, the best of both motions, from which a shape is looked for
SHARE_BEHIND = "bearing"  # shape of a gear: share of the joint's friction behind it
MISFIT = 1.1  # variances of the noise on unseen motion, from which on a shape is looked at again


def decided(shop: Workshop, others: Sequence[Trial], found: Score) -> Score:
    """A candidate at the shape that estimation and validation recordings prefer together.

    As it is where it foretells the other motion well, nothing of it is open, or the other shape
    foretells that no better.

    Args:
        shop: The laid-out data.
        others: Additions that it stands beside.
        found: At the shape that the estimation recordings prefer.
    """
    trial = found.trial
    if trial.is_free_form or not trial.values or is_late(trial):
        return found
    if trial.between_repetitions or not shop.validation:
        return found
    if shop.layout_for(others) is not shop.mean:  # whose mean does not tell how to foretell
        return found
    told = _told(shop, others, found)
    if told is None:
        return found
    fit = shop.fit(others, shop.layout(trial)).fit

    def paid(tried: Score) -> float:  # a formula of more terms follows both motions more closely
        return told(tried) - tried.price(fit.rows.count)

    starts = [score(moved(t, fit.rows, shop.context), fit) for t in _usual(shop, trial)]
    # Further terms of a formula may follow one motion alone.
    starts += shorter_formulas(found, fit, shop.context)
    if not is_unripe(trial):  # whose grid stands on another torque
        # One motion may rise to another crest than both together do.
        starts += [score(t, fit) for t in shop.physical if t.key == trial.key]
    plausible = [s for s in starts if implausible(s, shop.context) is None]
    plausible = [found, *plausible[:1], *sorted(plausible[1:], key=told)[-CRESTS:]]
    best = max((climb(s, fit, shop.context, told) for s in plausible), key=paid)
    if not _errs_less(shop, others, best.trial, trial):
        return found
    return dataclasses.replace(best, trial=dataclasses.replace(best.trial, decided=True))


def shapes_beside(
    shop: Workshop, others: Sequence[Trial], trial: Trial, joints: Collection[int]
) -> list[Trial]:
    """Other additions of some joints at the shapes that they take beside a further one; none if none has any.

    What was found before had to do some of its work, and foretells another motion by that.

    Args:
        shop: The laid-out data.
        others: Additions at the shapes that they have without it.
        trial: The further one.
        joints: Where shapes may move; what sits in none, such as a delay, may always.
    """
    beside = list(others)
    shaped = [
        k
        for k, t in enumerate(beside)
        if t.shapes and not t.is_free_form and not {None, *joints}.isdisjoint(t.places)
    ]
    # A delay acts on what a gear does, too.
    context = shop.context_with(shop.fit([*others, trial], bend=False)) if shaped else shop.context
    for k in shaped:
        rest, own = [*beside[:k], *beside[k + 1 :], trial], beside[k]
        fit = shop.fit(rest, shop.layout(own)).fit
        there = moved(own, fit.rows, context, contrast=own.contrast)
        found = at_rest(score(there, fit), fit, context)
        beside[k] = decided(shop, rest, found).trial
    return beside if shaped else []


def _usual(shop: Workshop, trial: Trial) -> list[Trial]:
    """A trial at the shapes that are usual, its formula as it is.

    Of a gear, all of the joint's friction before it or behind it: where it sits trades places
    with all other shapes.
    """
    shapes = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
    pairs = list(zip(trial.values, shapes, strict=True))
    if is_unripe(trial):
        ways = [
            tuple(getattr(s, end) if s.name == SHARE_BEHIND else v for v, s in pairs)
            for end in ("lower", "upper")
        ]
    else:
        ways = [tuple(v if s.scale == "formula" else s.default for v, s in pairs)]
    return [dataclasses.replace(trial, values=values) for values in ways]


def _errs_less(shop: Workshop, others: Sequence[Trial], one: Trial, other: Trial) -> bool:
    """Whether the error on unseen motion [N m] of the joints of two additions is less with one.

    White squares weigh what is fast: disturbances that move the arm are slow.
    """
    joints = sorted(one.group)
    ours, theirs = (shop.validation_rms(shop.fit([*others, t], bend=False)) for t in (one, other))
    if ours is None or theirs is None:
        return False
    return bool(np.mean((ours[joints] / theirs[joints]) ** 2) < 1)


def _told(shop: Workshop, others: Sequence[Trial], found: Score) -> Callable[[Score], float] | None:
    """What a shape says of both motions; None where the found one foretells the other well."""
    layout = shop.layout(found.trial)
    beside = shop.fit(others, layout, bend=False)
    unseen = shop.unseen_by([*others, found.trial])
    rows = unseen.rows
    if rows is None:
        return None
    errors = unseen.errors(beside)
    free = [
        dense(moved(t, rows, shop.context), *errors.shape) for t in beside.chosen if not t.fixed
    ]
    columns = np.concatenate([unseen.white, *free], axis=2)

    def left(tried: Score) -> Float[ndarray, " joints"]:
        """White squares of the other motion with this addition."""
        inside = sum(
            beside.fit.projection.basis[joint].T @ (block @ tried.coefficients)
            for joint, block in tried.trial.group.items()
        )
        there = moved(tried.trial, rows, shop.context)
        torque = dense(there, *errors.shape) @ tried.coefficients
        given = torque - columns @ (beside.fit.projection.inverse @ inside)
        return np.sum((errors - given) ** 2, axis=1)

    at_first = left(found) / unseen.counted
    own = sorted(found.trial.group)
    if at_first[own].mean() < MISFIT:
        return None
    unit = np.maximum(at_first, 1.0)
    chance = float(inflation_of(beside.fit)[own].mean())
    return lambda tried: tried.gain / chance - float(np.sum(left(tried) / unit))
