"""Whether recordings show how an arm changes in them, or only that they differ or jump."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.tables.workbench import Layout
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import inflation_of
from oed.diagnosis.terms.trials import Trial, white_group
from oed.diagnosis_new.noise.addition import Addition, normal_equations
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects import Effect
from oed.dynamics.effects.entries.history import start_of
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.thermal import FrictionJump, ThermalDrift, WarmFriction, since

NEARLY_ALL = 0.8  # share of what recordings differ by
LEAST_RECORDINGS = 4  # of which a thermometer is believed that foretells how they differ
MOMENTS = 50  # over a session, at which friction may jump


def differs_alone(shop: Workshop, others: Sequence[Trial], trial: Trial) -> str | None:
    """Why nothing tells a change over the session from recordings that differ; None if they do.

    Where it is only assumed in which order recordings were made, two of them may differ by
    anything. What changes must explain more than the same effect of a size of its own in each, and
    than what its columns gain in noise; or a load must be all that they differ by.

    Args:
        shop: The laid-out data.
        others: Additions beside it.
        trial: What would be added.
    """
    steady = None if shop.context.ordered else _steady(trial.effect)
    if steady is None:
        return None
    layout = shop.layout(trial)
    fit = shop.fit(others, layout).fit
    own = {
        joint: _each_its_own(block, fit.rows.starts.tolist())
        for joint, block in white_group(steady, layout.rows).items()
    }
    both = {joint: np.hstack([block, own[joint]]) for joint, block in trial.group.items()}
    left = shop.fit([*others, trial], layout).fit
    noise = float(inflation_of(left)[list(trial.group)].mean())
    within, apart = (
        normal_equations(fit.projection, fit.residual, g).solved() for g in (both, own)
    )
    price = shop.settings.decisive + (within.rank - apart.rank) * np.log(layout.rows.count)
    if within.gain > apart.gain + price * noise:
        return None
    if isinstance(trial.effect, PayloadChange) and _is_what_differs(layout, fit, trial, noise):
        return None
    if isinstance(trial.effect, WarmFriction) and len(layout.rows.prepared) >= LEAST_RECORDINGS:
        alone = normal_equations(fit.projection, fit.residual, trial.group).solved()
        if _is_nearly_all(alone, apart, noise):
            return None
    return "recordings of no known order differ, and none of them shows the change"


def comes_at_once(shop: Workshop, others: Sequence[Trial], trial: Trial) -> str | None:
    """Why friction that changes is no joint that warms: it jumps; None if it does not.

    Args:
        shop: The laid-out data.
        others: Additions beside it.
        trial: What would be added.
    """
    drift = trial.effect
    if not isinstance(drift, ThermalDrift | WarmFriction):
        return None
    layout = shop.layout(trial)
    fit = shop.fit(others, layout).fit
    start = drift.start if isinstance(drift, ThermalDrift) else start_of(shop.context, 1.0)
    t = np.concatenate([since(p.motion.t, start) for p in shop.estimation])
    moments = np.linspace(t.min(), t.max(), MOMENTS + 2)[1:-1]
    jumps = (FrictionJump(drift.joint, float(m), start, drift.width) for m in moments)
    groups = (trial.group, *(white_group(j, layout.rows, contrast=trial.contrast) for j in jumps))
    warm, *jumped = (normal_equations(fit.projection, fit.residual, g).solved() for g in groups)
    noise = float(inflation_of(shop.fit([*others, trial], layout).fit)[drift.joint])
    if max(j.gain for j in jumped) > warm.gain + shop.settings.decisive * noise:
        return "friction that jumps at one moment explains more"
    return None


def _is_what_differs(layout: Layout, fit: LinearFit, trial: Trial, noise: float) -> bool:
    """Whether a load does nearly all that parameters of its own would do for each recording.

    Warm friction, another offset or a link that was changed do something else.
    """
    starts = fit.rows.starts.tolist()
    own = {
        joint: _each_its_own(block, starts)[:, block.shape[1] :]
        for joint, block in enumerate(layout.regressor)
    }
    every, load = (
        normal_equations(fit.projection, fit.residual, g).solved() for g in (own, trial.group)
    )
    return _is_nearly_all(load, every, noise)


def _is_nearly_all(one: Addition, other: Addition, noise: float) -> bool:
    """Whether one addition explains nearly all that a fuller one does, but for what is noise."""
    return one.gain > NEARLY_ALL * (other.gain - other.rank * noise)


def _steady(effect: Effect) -> Effect | None:
    """An effect that changes over the session, as it would be without change; None of others."""
    if isinstance(effect, PayloadChange) and (effect.start is not None or effect.pickups):
        return dataclasses.replace(effect, moment=-np.inf, pickups=(), held_for=np.inf)
    if isinstance(effect, ThermalDrift) and effect.start is not None:
        return dataclasses.replace(effect, time_constant=np.inf)
    if isinstance(effect, WarmFriction):
        return ThermalDrift(effect.joint, np.inf, start=0.0, width=effect.width)
    return None


def _each_its_own(
    block: Float[ndarray, "rows columns"], starts: Sequence[int]
) -> Float[ndarray, "rows columns_of_all"]:
    """Columns that act in one recording each."""
    rows = np.arange(len(block))[:, None]
    return np.hstack([np.where((rows >= a) & (rows < b), block, 0.0) for a, b in pairwise(starts)])
