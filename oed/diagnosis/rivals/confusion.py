"""How often noise makes the wrong one of two rivals win, refitted with all their shapes.

Phi(-sqrt(lambda) / 2) (Atkinson and Fedorov 1975) is the chance of a wrong choice between two
models that have nothing to fit. A rival whose shapes are searched over a wide range fits noise
besides, and the diagnosis names by evidence, which charges for every parameter. So the
favourite's torque is drawn with noise many times, both are fitted, and the wrong ones counted
(a parametric bootstrap; Efron and Tibshirani 1993, section 6.5). The favourite's shape is itself
known to within the noise at hand: the truth is one of several (a mean over what it may be, as in
Ponce de Leon and Atkinson 1991, Biometrika 78(3)).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.margin import (
    CLOSE,
    are_lags,
    is_first_order,
    of_noise,
    of_sampling,
    of_smoothing,
)
from oed.diagnosis.rivals.drawn import Drawn, best_of_shapes, noise_beside
from oed.diagnosis.rivals.favourite import Pair, best_imitations, context_beside, torque_beside
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import score
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.experiment.preparation.prepared import Prepared

DRAWS = 400  # of the noise: a rate of 10 % is known within 1.5 points
TRUTHS = 8  # that the data at hand leave open


@dataclass(frozen=True)
class Confusion:
    """Predicted chances where the favourite is true.

    Attributes:
        by_fit: Of a better fit of the rival, whatever it cost.
        by_name: Of the rival's being named: by evidence, by plainness where that does not decide.
        resolved: Of a decisive lead of the favourite.
    """

    by_fit: float
    by_name: float
    resolved: float


def confusion(
    shop: Workshop,
    pair: Pair,
    rng: np.random.Generator,
    further: Prepared | None = None,
    *,
    draws: int = DRAWS,
    truths: int = TRUTHS,
) -> Confusion:
    """Draw the favourite's torque with noise, fit both rivals, and count.

    Args:
        shop: The data at hand, and their noise.
        pair: Favourite, its coefficients, and rival.
        rng: Of the noise.
        further: A recording besides those at hand, run as often as the first of these.
        draws: Of the noise.
        truths: Of the favourite that noise on the data at hand leaves open; with 1 it is as it is.
    """
    pairs = [pair, *_others_like(shop, pair, rng, truths - 1)]
    fits = [torque_beside(shop, p, further) for p in pairs]
    fit, torques = fits[0], np.stack([f.residual for f in fits], axis=2)
    drawn = torques[:, :, np.arange(draws) % len(pairs)] + noise_beside(fit, rng, draws)
    count = shop.full.rows.count * fit.rows.count / shop.layout_for([pair[0], pair[2]]).rows.count
    # What explains the favourite's torque best is not what explains the measured one best, and a
    # shape that misses it by a step of the grid may lose more than noise could make up for.
    context = context_beside(shop, further)
    imitations = [found.trial for found in best_imitations(context, pair[2], fits)]
    own, other = (
        best_of_shapes(context, trials, fit, drawn, count)
        for trials in ([p[0] for p in pairs], imitations)
    )
    return _judged(shop, own, other, fit)


def _others_like(shop: Workshop, pair: Pair, rng: np.random.Generator, count: int) -> list[Pair]:
    """What noise on the data at hand makes of the favourite."""
    if count < 1:
        return []
    fit = torque_beside(shop, pair, None)
    torque = fit.residual[:, :, None] + noise_beside(fit, rng, count)
    found = best_of_shapes(shop.context, [pair[0]], fit, torque, float(fit.rows.count))
    scores = [
        score(trial, dataclasses.replace(fit, residual=torque[:, :, k]))
        for k, trial in enumerate(found.chosen())
    ]
    return [(s.trial, s.coefficients, pair[2]) for s in scores]


def _judged(shop: Workshop, own: Drawn, other: Drawn, fit: LinearFit) -> Confusion:
    """As `oed.diagnosis.candidates.telling.most_telling_first` and its margins have it."""
    one, two = own.trials[0], other.trials[0]
    lead, margin = own.evidence - other.evidence, _margin(shop, own, other, fit)
    nested = is_first_order(one, two)
    tied = np.abs(lead) < (margin if nested else CLOSE)
    plainer = own.cancelled > other.cancelled
    if nested:
        plainer = np.where(own.freedom == other.freedom, plainer, own.freedom > other.freedom)
    return Confusion(
        by_fit=float(np.mean(other.gain > own.gain)),
        by_name=float(np.mean(np.where(tied, plainer, lead < 0))),
        resolved=float(np.mean(lead >= margin)),
    )


def _margin(shop: Workshop, own: Drawn, other: Drawn, fit: LinearFit) -> Float[ndarray, " draws"]:
    """By how much one must tell more, as `oed.diagnosis.candidates.margin.decisive_between` has it."""
    one, two = own.trials[0], other.trials[0]
    smoothing = of_smoothing(one, two) * np.maximum(own.gain, other.gain)
    margin = np.maximum(shop.settings.decisive, smoothing)
    if not are_lags(one, two):
        return margin
    both = list(zip(own.chosen(), other.chosen(), strict=True))
    share = np.array([of_sampling(shop, *trials) for trials in both])
    # No two late torques differ by less than one explains more.
    sampled = share * np.abs(own.gain - other.gain)
    return np.maximum(margin, sampled) + of_noise(both[0], [fit.rows])
