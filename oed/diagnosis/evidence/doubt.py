"""Names whose size the data leave open: zero lies within their own interval."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import chi2

from oed.diagnosis.candidates.ripening import is_late
from oed.diagnosis.candidates.telling import foretells_most
from oed.diagnosis.evidence.estimates import from_declared
from oed.diagnosis.evidence.profile import UNIFORM, axes_of
from oed.diagnosis.evidence.uncertainty import at_given_shapes
from oed.diagnosis.evidence.verdict import mends
from oed.diagnosis.tables.workbench import Augmented, comes_first
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.catalogue import CATALOGUE, Context

OPEN = 0.9  # of the deviation of a shape of which nothing is known
AT_BOUND = 0.01  # of its range
LEAD = 5.0  # deviations: what encoder noise makes of a torque that comes first is up to 4.6


def doubtful_name(shop: Workshop, whole: Augmented) -> Trial | None:
    """A name whose size is zero within its uncertainty, at the shapes that it has.

    A search believes the noise to be what repetitions show. Where it is not, the covariance that
    lets each block of rows err as it does is the wider one, and has the last word (Wald's test,
    Bonferroni's level for a choice among all candidates). A free form of the same coordinate that
    mends a name can follow it whole, and says nothing against it. Nor is in doubt what foretells
    much of what its joints do on a motion that it was not fitted to. The size of a delay or a lag
    is its time; encoder noise that the control answers comes first too, in every single motion, so
    that a torque which does must be clear of that. What has its size in its shapes is in doubt, too,
    where none of these is known.

    Args:
        shop: The laid-out data.
        whole: All additions, with the uncertainty of their parameters.
    """
    level = shop.settings.level / len({t.key for t in shop.physical})
    for trial, coefficients, covariance in zip(
        whole.chosen, whole.coefficients, whole.covariances, strict=True
    ):
        if trial.is_free_form or _is_mended(trial, whole.chosen):
            continue
        if trial.fixed and _is_unknown(trial, covariance, shop.context):
            return trial
        if trial.fixed and not is_late(trial):
            continue
        if trial.fixed:
            wald, count = _lateness(trial, covariance, shop.context), 1
            if comes_first(trial) and shop.mean is shop.full and wald < LEAD**2:
                return trial
        else:
            count = len(coefficients)
            own = at_given_shapes(covariance, count)
            values, own = from_declared(shop, trial, coefficients, own)
            wald = float(values @ np.linalg.pinv(own, hermitian=True) @ values)
        others = [t for t in whole.chosen if t is not trial]
        if chi2.sf(wald, count) > level and not foretells_most(shop, others, trial, ()):
            return trial
    return None


def _lateness(trial: Trial, covariance: Float[ndarray, "shapes shapes"], context: Context) -> float:
    """Square of the time by which a torque is late, in deviations."""
    time = CATALOGUE[trial.name].shapes_for(context, trial.target)[0]
    deviation = np.sqrt(covariance[0, 0]) * time.slope_at(trial.values[0])
    return float((trial.values[0] / max(deviation, np.finfo(float).tiny)) ** 2)


def _is_unknown(
    trial: Trial, covariance: Float[ndarray, "columns columns"], context: Context
) -> bool:
    """Whether the data leave every shape as open as its range."""
    deviations = np.sqrt(np.diag(covariance))[-len(trial.values) :]
    axes = axes_of(trial, context)
    is_open = [
        deviations[place] > OPEN * UNIFORM or min(axis, 1 - axis) < AT_BOUND for place, axis in axes
    ]
    return bool(axes) and all(is_open)


def _is_mended(trial: Trial, chosen: Sequence[Trial]) -> bool:
    """Whether a freer form of an effect stands beside it."""
    return any(mends(other, trial) for other in chosen)
