"""One factor at a time: what a recording is like, and the logs that come of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import lfilter

from oed.dynamics.motion import Motion
from studies.bench.excitation import random_fourier_motion
from studies.estimators.arms import SEED, ContestArm, arm_of
from studies.estimators.loop import PERIOD, Disturbances, simulate

SECONDS = 10.0
COLOUR = 2.0  # [Hz] corner of coloured noise and of what the arm feels
JITTER = 0.4  # rms of a reading before it is rounded, in steps
STRIBECK = 0.4  # of Coulomb friction, at rest
POOR = 0.25  # of the amplitude, at the same frequencies


@dataclass(frozen=True)
class Condition:
    """What a recording is like.

    Attributes:
        noise: "white" and "coloured" are of the torque signal; "felt" moves the arm, and its
            controller answers.
        bits: Of the encoders, a turn or metre.
        every: Control periods a logged row.
        delay: Control periods by which the torque is logged late.
        stribeck: Of Coulomb friction at rest, which no model has.
        amplitude: Of the motion.
    """

    noise: Literal["white", "coloured", "felt"] = "white"
    bits: int = 17
    every: int = 4
    delay: int = 0
    stribeck: float = 0.0
    amplitude: float = 1.0


CONDITIONS = {
    "base": Condition(),
    "coloured noise": Condition(noise="coloured"),
    "felt noise": Condition(noise="felt"),
    "coarse encoder": Condition(bits=12),
    "slow log": Condition(every=20),
    "late torque": Condition(delay=4),
    "wrong friction": Condition(stribeck=STRIBECK),
    "poor motion": Condition(amplitude=POOR),
}


@dataclass(frozen=True)
class Logs:
    """R logs of one motion.

    Attributes:
        reference: That was asked for, at the control period.
        t: (N,) [s].
        q: (R, N, n) as read [rad or m].
        tau: (R, N, n) as logged [N m or N].
        every: Control periods a row.
    """

    reference: Motion
    t: Float[ndarray, " rows"]
    q: Float[ndarray, "runs rows joints"]
    tau: Float[ndarray, "runs rows joints"]
    every: int


def motion_of(arm: ContestArm, rng: np.random.Generator, amplitude: float = 1.0) -> Motion:
    """A random Fourier motion about its own mean, at the control period."""
    motion = random_fourier_motion(arm.robot.limits, SECONDS, arm.highest, PERIOD, rng)
    middle = motion.q.mean(axis=0)
    q = middle + amplitude * (motion.q - middle)
    return Motion(motion.t, q, amplitude * motion.dq, amplitude * motion.ddq)


@lru_cache(maxsize=1)
def logs_of(key: str, condition: Condition, draws: int) -> Logs:
    """The same for every estimator."""
    arm = arm_of(key)
    motion = motion_of(arm, np.random.default_rng(SEED), condition.amplitude)
    rng = np.random.default_rng([SEED, draws])
    shape = (len(motion), arm.robot.n, draws)
    white = rng.standard_normal(shape) * arm.noise[:, None]
    slow = _coloured(rng, shape) * arm.noise[:, None]
    step = 2 * np.pi / 2**condition.bits
    jitter = JITTER * step * rng.standard_normal(shape)
    felt = slow if condition.noise == "felt" else np.zeros(shape)
    runs = simulate(
        key,
        arm.truth[None],
        motion,
        Disturbances(felt, jitter, step),
        condition.stribeck * arm.coulomb,
    )
    # A command holds for a period: at a sampling instant the torque is the mean on either side.
    torque = (np.concatenate([runs.torque[:1], runs.torque[:-1]]) + runs.torque) / 2
    torque = torque + {"white": white, "coloured": slow, "felt": 0.3 * white}[condition.noise]
    if condition.delay:
        torque = np.concatenate([torque[: condition.delay], torque[: -condition.delay]])
    rows = slice(None, None, condition.every)
    q, tau = (np.moveaxis(x[rows], 2, 0) for x in (runs.measured, torque))
    return Logs(motion, motion.t[rows], q, tau, condition.every)


def _coloured(
    rng: np.random.Generator, shape: tuple[int, int, int]
) -> Float[ndarray, "samples joints runs"]:
    """First-order noise of unit variance."""
    pole = np.exp(-2 * np.pi * COLOUR * PERIOD)
    start = rng.standard_normal((1, *shape[1:]))
    pushed = np.sqrt(1 - pole**2) * rng.standard_normal((shape[0] - 1, *shape[1:]))
    return np.asarray(lfilter([1.0], [1.0, -pole], np.concatenate([start, pushed]), axis=0))
