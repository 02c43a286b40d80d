"""The motion on which two rival explanations differ most (T-optimality).

Atkinson and Fedorov 1975, "The design of experiments for discriminating between two rival
models", Biometrika 62(1): maximise lambda = min over the rival's parameters of the squared white
distance between its prediction and the favourite's. Two rivals are then confused with the
probability Phi(-sqrt(lambda) / 2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import norm

from oed.design.default_limits import with_default_limits
from oed.design.limits import fill
from oed.design.trajectories import FourierClass
from oed.diagnosis.linear_fit import project, whitened_regressor
from oed.diagnosis.prepare import Prepared
from oed.diagnosis.trials import Trial
from oed.diagnosis.workbench import moved, shape_derivatives
from oed.diagnosis.workshop import Workshop
from oed.dynamics.motion import Motion

HARMONICS = (5, 10, 15)  # more harmonics separate delays and lags, few separate slow effects
AMPLITUDES = (1.0, 0.3, 0.1)  # of what the limits allow: small ones tell Dahl from Stribeck


@dataclass(frozen=True)
class NextExperiment:
    """A motion that tells rivals apart.

    Attributes:
        motion: One period on the fine grid.
        separation: lambda of the new motion, the least over the pairs.
        separation_now: lambda of the recordings at hand.
        error_rate: Predicted chance of confusing the least separable pair on the new motion.
        error_rate_now: The same on the recordings at hand.
        pairs: Names of the rivals, in words.
        tried: Number of motions that were compared.
        notes: Limits that had to be assumed.
    """

    motion: Motion
    separation: float
    separation_now: float
    error_rate: float
    error_rate_now: float
    pairs: tuple[str, ...]
    tried: int
    notes: tuple[str, ...]


def design_discriminating(
    shop: Workshop,
    pairs: Sequence[tuple[Trial, Float[ndarray, " columns"], Trial]],
    rng: np.random.Generator,
    *,
    candidates: int = 48,
) -> NextExperiment:
    """The best of a number of random motions within the limits.

    Args:
        shop: The data at hand: model, noise, limits.
        pairs: Favourite, its coefficients, and rival.
        rng: Draws motions.
        candidates: Motions to compare.
    """
    robot, notes = with_default_limits(shop.baseline.model.robot)
    pattern = shop.mean.rows.prepared[0]
    horizon = float(pattern.motion.t[-1] - pattern.motion.t[0])
    best: tuple[float, Motion] | None = None
    for k in range(candidates):
        cycle = FourierClass(horizon, robot.limits, harmonics=HARMONICS[k % len(HARMONICS)])
        z = fill(cycle, cycle.draw(rng), robot.limits)
        amplitude = AMPLITUDES[(k // len(HARMONICS)) % len(AMPLITUDES)]
        z = cycle.shrink(z, np.full(robot.n, amplitude))
        motion = cycle.motion(z, np.arange(0.0, horizon, 1 / pattern.band.rate))
        value = min(separation(shop, as_prepared(pattern, motion), *pair) for pair in pairs)
        if best is None or value > best[0]:
            best = (value, motion)
    if best is None:
        raise ValueError(f"{candidates=} motions leave nothing to choose from")
    now = min(separation(shop, pattern, *pair) for pair in pairs)
    return NextExperiment(
        motion=best[1],
        separation=best[0],
        separation_now=now,
        error_rate=error_rate(best[0]),
        error_rate_now=error_rate(now),
        pairs=tuple(f"{a.name} or {b.name}" for a, _, b in pairs),
        tried=candidates,
        notes=notes,
    )


def error_rate(separation: float) -> float:
    """Chance that noise makes the wrong one of two models fit better."""
    return float(norm.cdf(-np.sqrt(max(separation, 0.0)) / 2))


def separation(
    shop: Workshop,
    recording: Prepared,
    favourite: Trial,
    coefficients: Float[ndarray, " columns"],
    rival: Trial,
) -> float:
    """lambda: what of the favourite's torque no parameters of base model and rival reproduce."""
    rows = shop.baseline.rows((recording,))
    joints = shop.context.n
    mine = _dense(moved(favourite, rows, shop.context), joints, rows.count) @ coefficients
    theirs = moved(rival, rows, shop.context)
    own = _dense(theirs, joints, rows.count)
    blocks = [whitened_regressor(shop.baseline.model, shop.baseline.columns, rows)]
    target = mine
    if theirs.fixed:
        target = mine - own.sum(axis=2)
    else:
        blocks.append(own)
    ones = np.ones(own.shape[2])
    blocks.append(shape_derivatives(theirs, ones, rows, shop.context))
    residual = project(np.concatenate(blocks, axis=2)).residual(target)
    return float(np.sum(residual**2))


def as_prepared(pattern: Prepared, motion: Motion) -> Prepared:
    """A motion that nobody has run yet, in the clothes of a recording."""
    silent = np.zeros_like(motion.q)
    torque = pattern.band.apply(silent)
    t = pattern.band.instants(motion.t)
    return Prepared(
        name="next",
        role="estimation",
        motion=motion,
        fine_torque=silent,
        torque=torque,
        t=t,
        band=pattern.band,
        repetition=np.full(len(t), -1),
        period=None,
        sign_noise=pattern.sign_noise,
        recorded=np.ones(len(motion), dtype=bool),
    )


def _dense(trial: Trial, joints: int, rows: int) -> Float[ndarray, "joints rows columns"]:
    dense = np.zeros((joints, rows, next(iter(trial.group.values())).shape[1]))
    for joint, block in trial.group.items():
        dense[joint] = block
    return dense
