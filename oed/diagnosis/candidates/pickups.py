"""A load that is taken up at a moment of its own in every recording.

When an arm grips something is no property of it: whoever commands it decides that anew. The load
is the same, and known from the recordings that it was fitted to; its moment in any other is read
off there, one number a recording, at what it then explains.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.crests import climbed
from oed.diagnosis.tables.predict import fine_torque, prediction_errors
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import at_rest
from oed.diagnosis.terms.scores import Score, inflation_of, score
from oed.diagnosis.terms.trials import Trial, moved
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.rows.model_columns import filtered_columns
from oed.dynamics.effects.payload import PayloadChange, PickUp
from oed.experiment.preparation.prepared import Prepared

ROUNDS = 3  # of the load by its moments, and these by the load
NEAR = 40  # rows in which a moment is looked for, of those that it seems to be in
FINE = 8  # parts of a row to which a moment is read off
OWN_CLOCK = 0.0  # of the shape that says which clock counts


def with_own_moments(shop: Workshop, others: Sequence[Trial], found: Score) -> Score:
    """A load as each recording shows it to be taken up, where that tells more by far.

    The tables then have its moments (`Workshop.take_up`).

    Args:
        shop: The laid-out data.
        others: Additions that it stands beside.
        found: A candidate of any name.
    """
    if not is_load(found.trial):
        return found
    if shop.pickups:  # of a load that was given up
        shop.take_up(())
        found = _again(shop, others, found.trial)
    best, least = (found, ()), np.inf
    as_found = _left(shop, others, found)
    for start in (found, _by_own_clock(shop, others, found)):
        shop.take_up(())
        tried = _with_moments(shop, others, start)
        left = _left(shop, others, tried)
        gain = np.sum((as_found - left) / np.maximum(left / _counted(shop), 1.0))
        worth = len(shop.pickups) * _price(shop) - float(gain)
        if shop.pickups and worth < min(least, 0.0) and _is_shown_unseen(shop, others, left[1]):
            best, least = (tried, shop.pickups), worth
    shop.take_up(best[1])
    return best[0]


def _is_shown_unseen(
    shop: Workshop, others: Sequence[Trial], left: Float[ndarray, " joints"]
) -> bool:
    """Whether validation recordings show a load for a while, or an arm that is rid of it.

    One that is never there again is proven if without it the arm is as it was before: what was
    fitted to both foretells neither. True without such recordings.

    Args:
        shop: The laid-out data, with the load's moments.
        others: Additions that the load stands beside.
        left: White squares that it leaves of the validation recordings.
    """
    own = {p.first: p.moment for p in shop.pickups}
    spans = [(float(p.motion.t[0]), float(p.motion.t[-1])) for p in shop.validation]
    if not spans or any(own.get(first, first) < last for first, last in spans):
        return True
    before = shop.unseen_full.left(shop.fit(others, shop.full, bend=False))
    unit = np.maximum(left / shop.unseen_full.counted, 1.0)
    return float(np.sum((before - left) / unit)) > _price(shop)


def _with_moments(shop: Workshop, others: Sequence[Trial], start: Score) -> Score:
    """A load by the moments that recordings show, and these by the load."""
    best = start
    for number in range(ROUNDS):
        whole = shop.fit([*others, best.trial], shop.full, bend=False)
        pickups = read_off(shop, whole, (*shop.estimation[1:], *shop.validation))
        if pickups == shop.pickups:
            break
        shop.take_up(pickups)
        # Only the first moments may put the load in another swing of the arm.
        best = _again(shop, others, best.trial, elsewhere=number == 0)
    return best


def take_up_again(shop: Workshop, chosen: Sequence[Trial]) -> None:
    """Moments of a load read off anew, beside all that is known by now."""
    if shop.pickups and any(map(is_load, chosen)):
        whole = shop.fit(chosen, shop.full, bend=False)
        shop.take_up(read_off(shop, whole, (*shop.estimation[1:], *shop.validation)))


def read_off(
    shop: Workshop, whole: Augmented, recordings: Sequence[Prepared]
) -> tuple[PickUp, ...]:
    """When a load is taken up in each of some recordings, where that is a moment of its own.

    Args:
        shop: The laid-out data.
        whole: The additions, fitted.
        recordings: In which to look; to the first one that the load was fitted to belongs the
            moment among its shapes.
    """
    price = _price(shop) * float(inflation_of(whole.fit).mean())
    pairs = list(zip(whole.chosen, whole.coefficients, strict=True))
    load, coefficients = next(p for p in pairs if is_load(p[0]))
    rest = [(t, c) for t, c in pairs if t is not load]
    bare = dataclasses.replace(
        whole, chosen=tuple(t for t, _ in rest), coefficients=tuple(c for _, c in rest)
    )
    found = []
    for recording in recordings:
        columns = filtered_columns(shop.baseline.model, recording, shop.baseline.columns)
        (error,) = prediction_errors(bare, (recording,), [columns])
        own = moment_in(
            recording, shop.baseline, error, _held_and_common(load, coefficients, recording), price
        )
        if own is not None:
            found.append(own)
    return tuple(found)


def _held_and_common(
    load: Trial, coefficients: Float[ndarray, " columns"], recording: Prepared
) -> Float[ndarray, "2 samples joints"]:
    """Torque of a load that is there all the time, and of one that comes as in the first recording."""
    t = recording.motion.t
    always = PickUp(float(t[0]), float(t[-1]), float(t[0]))
    ways = (_with_pickups(load, own) for own in ((always,), ()))
    return np.stack([fine_torque(way, coefficients, recording) for way in ways])


def _with_pickups(load: Trial, pickups: tuple[PickUp, ...]) -> Trial:
    effect = load.effect
    if isinstance(effect, PayloadChange):
        effect = dataclasses.replace(effect, pickups=pickups)
    return dataclasses.replace(load, effect=effect)


def is_load(trial: Trial) -> bool:
    """Whether an addition is a load that is taken up at some moment."""
    return isinstance(trial.effect, PayloadChange)


def moment_in(
    recording: Prepared,
    baseline: Baseline,
    error: Float[ndarray, "rows joints"],
    held_and_common: Float[ndarray, "2 samples joints"],
    price: float,
) -> PickUp | None:
    """When a load is taken up in a recording, and put down again; None if as in the first.

    Args:
        recording: In which to look.
        baseline: Its noise whitens.
        error: Of a prediction without the load [N m].
        held_and_common: Torque of the load if it is there all the time, and if it comes when it
            does in the first recording, on the fine grid [N m].
        price: Least fall of the white squares, against no load and against the common moment.
    """
    held, common = held_and_common
    t, rows = recording.motion.t, baseline.rows((recording,))

    def white(torque: Float[ndarray, "samples joints"]) -> Float[ndarray, " rows"]:
        """Squares of each row beside a torque of the load."""
        left = error - recording.band.apply(torque)
        return np.sum(
            [rows.whiten([x[:, None]], j)[:, 0] ** 2 for j, x in enumerate(left.T)], axis=0
        )

    without, within = white(np.zeros_like(held)), white(held)

    def left_from(
        moments: Float[ndarray, " count"], release: float = np.inf
    ) -> Float[ndarray, " count"]:
        there = ((t >= m) & (t < release) for m in moments)
        return np.array([white(np.where(own[:, None], held, 0.0)).sum() for own in there])

    # Nearly what is left if the load comes just before each row: all but the step that it makes.
    nearly = np.cumsum(without) - without + np.cumsum(within[::-1])[::-1]
    row = 1 / recording.band.analysis_rate
    seen = recording.band.instants(t)[np.argsort(nearly)[:NEAR]]
    squares = left_from(seen)
    fine = seen[np.argmin(squares)] + row * np.arange(-FINE, FINE + 1) / FINE
    left = left_from(fine)
    moment, least = float(fine[np.argmin(left)]), float(left.min())
    # The arm hardly shows when, while the load's torque turns its sign.
    likely = np.exp(
        -np.maximum(squares - least, 0.0) / (2 * max(least / float(rows.counted.sum()), 1.0))
    )
    spread = likely @ (seen - moment) ** 2 / max(float(likely.sum()), 1e-300)
    deviation = float(np.sqrt(min(spread, np.ptp(t) ** 2 / 12) + (row / FINE) ** 2 / 12))
    release = np.inf
    instants = recording.band.instants(t)
    start, end = (instants[k] for k in _best_stretch(without - within))
    if end < instants[-1]:  # else it is not put down
        near = row * np.arange(-FINE, FINE + 1) / FINE
        begun = start + near[[np.argmin(left_from(start + near, end))]]
        left = np.array([left_from(begun, float(e))[0] for e in end + near])
        if left.min() < least - price:
            moment, release = float(begun[0]), float(end + near[np.argmin(left)])
            least, deviation = float(left.min()), row / np.sqrt(12)
    if least > float(without.sum()) - price:
        moment, release, least, deviation = np.inf, np.inf, float(without.sum()), 0.0
    if least > float(white(common).sum()) - price:
        return None
    return PickUp(float(t[0]), float(t[-1]), moment, deviation, release)


def _best_stretch(gains: Float[ndarray, " rows"]) -> tuple[int, int]:
    """First and last row of the stretch whose gains add up to most (Kadane's algorithm)."""
    sums = np.concatenate([[0.0], np.cumsum(gains)])
    least = np.minimum.accumulate(sums)
    last = int(np.argmax(sums[1:] - least[:-1]))
    return int(np.argmin(sums[: last + 1])), last


def _by_own_clock(shop: Workshop, others: Sequence[Trial], found: Score) -> Score:
    """A load whose moment counts from the start of its recording."""
    effect, (moment, clock, held) = found.trial.effect, found.trial.values
    if clock == OWN_CLOCK:
        return found
    if len(shop.estimation) == 1 and isinstance(effect, PayloadChange):
        start = shop.estimation[0].motion.t[0] - (effect.start or 0.0)
        own = dataclasses.replace(found.trial, values=(moment - float(start), OWN_CLOCK, held))
        return _again(shop, others, own)
    fit = shop.fit(others, shop.full).fit
    tried = [t for t in shop.physical if t.key == found.trial.key and t.values[1] == OWN_CLOCK]
    return max((score(shop.renewed(t), fit) for t in tried), key=lambda s: s.gain)


def _again(
    shop: Workshop, others: Sequence[Trial], trial: Trial, *, elsewhere: bool = True
) -> Score:
    """A load on the tables as they are now, at its best moment, or at the best one nearby."""
    fit = shop.fit(others, shop.full).fit
    here = score(moved(trial, fit.rows, shop.context, contrast=trial.contrast), fit)
    if (
        elsewhere and len(shop.estimation) > 1
    ):  # what others show of the load may put it in another swing
        here = climbed(shop, here, fit)
    return at_rest(here, fit, shop.context)


def _left(
    shop: Workshop, others: Sequence[Trial], found: Score
) -> Float[ndarray, "estimation_and_validation joints"]:
    """White squares that a load leaves of each joint."""
    whole = shop.fit([*others, found.trial], shop.full, bend=False)
    return np.stack([np.sum(whole.fit.residual**2, axis=1), shop.unseen_full.left(whole)])


def _counted(shop: Workshop) -> Float[ndarray, "estimation_and_validation joints"]:
    return np.stack([np.maximum(shop.full.rows.counted, 1.0), shop.unseen_full.counted])


def _price(shop: Workshop) -> float:
    """What a moment must tell."""
    return shop.settings.decisive + float(np.log(shop.full.rows.count))
