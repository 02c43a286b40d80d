"""One motion of an arm with hard sign friction, logged again and again with noise of its own.

Torques are exact along the motion that the arm makes; positions are read by 17-bit encoders. Noise is of the
torque signal, white or coloured, or it is felt: it moves the arm, and the arm's controller answers.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import lfilter

from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from studies.bench.excitation import random_fourier_motion
from studies.bench.robots import ROBOTS

RATE = 250.0  # [Hz] of the logs
PERIOD = 10.0  # [s] of the motion
REPETITIONS = 3
ENCODER = 2 * np.pi / 2**17  # [rad]
COLOUR = 2.0  # [Hz] corner of coloured noise and of what the arm feels
WHITE_SHARE = 0.3  # of the noise, on top of what is coloured or felt
BANDWIDTH = 25.0  # [rad/s] of the position control, critically damped
SEED = 20010218
NoiseKind = Literal["white", "coloured", "felt"]
ARMS = ("ur5", "panda")
NOISES: tuple[NoiseKind, ...] = ("white", "coloured", "felt")


@dataclass(frozen=True)
class Case:
    """One experiment.

    Attributes:
        arm: Key of the bench's robots.
        noise: "white" and "coloured" are of the torque signal; "felt" moves the arm, and its controller
            answers.
        experiment: Number of it, which seeds its noise.
    """

    arm: str
    noise: NoiseKind
    experiment: int

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (self.arm, self.noise, str(self.experiment))


@dataclass(frozen=True)
class Truth:
    """An arm and the motion that all its experiments run.

    Attributes:
        model: With friction whose sign is exact.
        parameters: (p,) of it.
        motion: All repetitions, one after another.
        inertia: (n,) least own inertia of each joint along the motion [kg m^2].
        noise: (n,) deviation of the torque's noise [N m].
    """

    model: TorqueModel
    parameters: Float[ndarray, " parameters"]
    motion: Motion
    inertia: Float[ndarray, " joints"]
    noise: Float[ndarray, " joints"]


@cache
def truth_of(arm: str) -> Truth:
    """The same for every experiment of an arm."""
    kind = ROBOTS[arm]
    with tempfile.TemporaryDirectory() as folder:
        robot = kind.load(Path(folder))
    bodies = kind.mass(robot)
    friction = [x for pair in zip(kind.coulomb, kind.viscous, strict=True) for x in pair]
    model = TorqueModel.standard(robot)
    parameters = np.concatenate([bodies, friction])
    rng = np.random.default_rng(SEED)
    once = random_fourier_motion(robot.limits, PERIOD, kind.highest, 1 / RATE, rng)
    t = np.arange(REPETITIONS * len(once)) / RATE
    motion = Motion(t, *(np.tile(x, (REPETITIONS, 1)) for x in (once.q, once.dq, once.ddq)))
    inertia = _own_inertia(model, parameters, once)
    return Truth(model, parameters, motion, inertia, np.array(kind.noise))


def _own_inertia(
    model: TorqueModel, parameters: Float[ndarray, " parameters"], motion: Motion
) -> Float[ndarray, " joints"]:
    """Least diagonal entry of the mass matrix along a motion: torque per own acceleration."""
    few = motion[:: len(motion) // 50]
    still = few.ddq * 0.0
    base = model.torque(parameters, Motion(few.t, few.q, few.dq, still))
    entries = []
    for j in range(model.robot.n):
        unit = still + np.eye(model.robot.n)[j]
        entries.append((model.torque(parameters, Motion(few.t, few.q, few.dq, unit)) - base)[:, j])
    return np.min(entries, axis=1)


def simulate(case: Case) -> DataSet:
    """The log of one experiment, as a data set."""
    truth = truth_of(case.arm)
    rng = np.random.default_rng(
        [SEED, ARMS.index(case.arm), NOISES.index(case.noise), case.experiment]
    )
    samples, joints = truth.motion.q.shape
    white = rng.standard_normal((samples, joints)) * truth.noise
    slow = _coloured(rng, samples, joints) * truth.noise
    motion = truth.motion
    if case.noise == "felt":
        motion = _shaken(truth, slow)
    # What the arm feels, the drive need not give.
    added = {"white": white, "coloured": slow, "felt": -slow}[case.noise]
    tau = truth.model.torque(truth.parameters, motion) + added
    if case.noise != "white":
        tau += WHITE_SHARE * white
    turns = np.floor(motion.t / PERIOD + 1e-9).astype(int)
    logged = Recording(
        "log", "estimation", motion.t, ENCODER * np.round(motion.q / ENCODER), tau, repetition=turns
    )
    robot = truth.model.robot
    return DataSet(case.arm, "simulated", "none", robot, "measured", recordings=(logged,))


def _coloured(
    rng: np.random.Generator, samples: int, joints: int
) -> Float[ndarray, "samples joints"]:
    """First-order noise of unit variance."""
    pole = np.exp(-2 * np.pi * COLOUR / RATE)
    start = rng.standard_normal((1, joints))
    innovation = np.sqrt(1 - pole**2) * rng.standard_normal((samples - 1, joints))
    return np.asarray(lfilter([1.0], [1.0, -pole], np.vstack([start, innovation]), axis=0))


def _shaken(truth: Truth, felt: Float[ndarray, "samples joints"]) -> Motion:
    """The motion with each joint moved by what it feels, under critically damped position control.

    M (x'' + 2 w x' + w^2 x) = torque, joint by joint; the torque of the moved arm is exact all the same.
    """
    step, w, motion = 1 / RATE, BANDWIDTH, truth.motion
    x, v = np.zeros_like(felt), np.zeros_like(felt)
    push = felt / truth.inertia
    a = np.zeros_like(felt)
    for k in range(len(felt) - 1):
        a[k] = push[k] - 2 * w * v[k] - w * w * x[k]
        v[k + 1] = v[k] + step * a[k]
        x[k + 1] = x[k] + step * v[k + 1]
    a[-1] = push[-1] - 2 * w * v[-1] - w * w * x[-1]
    return Motion(motion.t, motion.q + x, motion.dq + v, motion.ddq + a)
