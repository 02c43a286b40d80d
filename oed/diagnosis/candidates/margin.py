"""By how much one of two rivals must tell more than the other to be the one that is meant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.calming import calmed_beside
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score
from oed.diagnosis.terms.trials import Trial, white_group
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.delay import FilterLag
from oed.dynamics.effects.torque_change import TorqueChange

# Share of a gain by which two effects of one kind must differ besides: smoothing and sampling
# err in proportion to the signal.
SYSTEMATIC = 0.01
# A delayed torque that is interpolated between samples, or a mean over them, is a little of a lag
# too: its delays have a variance of up to a quarter of a sample's square. Twice that.
SAMPLED = 1 / 2
# Share of what two late torques make of noise by which it may be wrong: few repetitions show it.
UNCERTAIN = 1 / 4
# Of -2 log likelihood: by so little one of two laws may lead by chance.
CLOSE = 3.0
# Families in which one effect is another's first order: a delay of a lag, a rotor of a coupling, a
# spring of a spring with a gap, an offset of a spring in a joint.
NESTED = frozenset({"lag", "acceleration", "compliance", "even in speed"})


def decisive_between(shop: Workshop, one: Score, other: Score, unit: float = 1.0) -> float:
    """How much more one candidate must tell than another to be the one that is meant.

    Args:
        shop: The laid-out data.
        one: Candidate.
        other: Its rival.
        unit: In which gains are counted: the misfit of a model that lacks more than these.
    """
    decisive, trials = shop.settings.decisive, (one.trial, other.trial)
    if are_lags(*trials):
        unseen = shop.unseen_by(list(trials)).rows
        tables = [shop.mean.rows, *([unseen] if unseen else [])]
        share = of_sampling(shop, *trials)
        margin = max(decisive, share * _apart(trials, tables) / unit) if share else decisive
        return margin + of_noise(trials, tables) / unit
    return max(decisive, of_smoothing(*trials) * max(one.gain, other.gain) / unit)


def tied_within(
    shop: Workshop, one: Score, other: Score, unit: float = 1.0, close: float = CLOSE
) -> float:
    """How much more one candidate must tell than another to be named before a plainer one.

    An effect stands back behind its first order until it is the one that is meant; of two others
    the data's own choice is named, unless they are close.

    Args:
        shop: The laid-out data.
        one: Candidate.
        other: Its rival.
        unit: As in `decisive_between`.
        close: By how much of two others one may lead by chance.
    """
    if is_first_order(one.trial, other.trial):
        return decisive_between(shop, one, other, unit)
    return close


def of_smoothing(one: Trial, other: Trial) -> float:
    """Share of a gain that tells two effects of one kind apart by no more than it errs."""
    return SYSTEMATIC if is_of_kind(one, other) and not are_lags(one, other) else 0.0


def of_sampling(shop: Workshop, one: Trial, other: Trial) -> float:
    """Share of what two late torques differ by that a lag may explain more of a sampled delay.

    To second order a lag differs from a delay of its mean by the variance of its delays, V, and
    explains Q more of its own torque. Of a delayed one whose sampling has the variance S it
    explains Q (2 S / V - 1) more.
    """
    variance = max(abs(_variance(one) - _variance(other)), 1e-12)
    sampled = SAMPLED / shop.estimation[0].band.logged_rate ** 2
    return max(0.0, 2 * sampled / variance - 1)


def of_noise(trials: tuple[Trial, Trial], tables: Sequence[Rows]) -> float:
    """Of white squares of noise that one late torque takes away and another does not, the doubt."""
    own, its = (sum(float(calmed_beside((), t, r).sum()) for r in tables) for t in trials)
    return UNCERTAIN * abs(own - its)


def is_first_order(one: Trial, other: Trial) -> bool:
    """Whether of two of a kind the plainer is the other's first order."""
    return is_of_kind(one, other) and bool(NESTED & set(CATALOGUE[one.name].families))


def is_of_kind(one: Trial, other: Trial) -> bool:
    """Whether two effects of one family are attached to a common joint, or to the arm."""
    if one.is_free_form or other.is_free_form:
        return False
    families = (set(CATALOGUE[t.name].families) for t in (one, other))
    return bool(set(one.places) & set(other.places)) and bool(set.intersection(*families))


def are_lags(one: Trial, other: Trial) -> bool:
    """Whether both are a time by which torque is recorded late."""
    return is_of_kind(one, other) and "lag" in CATALOGUE[one.name].families


def _variance(late: Trial) -> float:
    """Of the delays that a late torque has, as its filter's second cumulant [s^2]."""
    effect = late.effect
    filtering = effect.measurement if isinstance(effect, TorqueChange) else None
    if not isinstance(filtering, FilterLag):
        return 0.0
    return filtering.time_constant**2 * (1 - 2 * filtering.curvature)


def _apart(trials: tuple[Trial, Trial], tables: Sequence[Rows]) -> float:
    """White squares by which two effects differ."""
    squares = 0.0
    for rows in tables:
        mine, its = (white_group(t.effect, rows) for t in trials)
        squares += sum(float(np.sum((mine[j].sum(1) - its[j].sum(1)) ** 2)) for j in mine)
    return squares
