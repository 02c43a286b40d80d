"""Arms that carry something, for studies: their torques by Drake, with friction that no model declares.

Along a random motion the rigid-body torque of arm and load is Drake's inverse dynamics. Added are Coulomb
and viscous friction, which changes from the bare day to the loaded one; a Stribeck term, which no model
declares; friction that grows with what the gears carry; noise, white or coloured; and, where it is asked
for, an offset of the torque that drifts between the days. Positions are read by encoders with steps.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from oed.dynamics.drake_plant import drake_torque
from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.robot import Robot
from oed.robot.attached_frame import AttachedFrame
from oed.robot.inertia import transform_parameters
from studies.bench.excitation import random_fourier_motion
from studies.carrying_arms import CarryingArm

PERIOD = 0.008  # [s] between rows of a log
LINK_SPREAD = 0.05  # relative scatter of each link's true mass about the file's
FRICTION_SPREAD = 0.15  # of friction from arm to arm
DAY_SPREAD = 0.10  # of Coulomb and viscous friction from the bare day to the loaded one
STRIBECK = ((0.1, 0.4), (0.05, 0.3))  # share of Coulomb friction; velocity [rad/s]
LOAD_FRICTION = (0.02, 0.12)  # share of the load that a gear loses
SIGN = 0.003  # [rad/s] over which true friction turns
COLOUR = 0.9  # coefficient of coloured noise at the log's rate: a corner at 2 Hz
ENCODER = 2 * np.pi / 2**18  # [rad]
MASSES = (0.1, 5.0)  # [kg]
SIZES = (0.04, 0.25)  # [m] of a load's sides
OFFSETS = (0.08, 0.15)  # [m] sideways, and away from the flange


@dataclass(frozen=True)
class TrueArm:
    """One arm as it truly is, on its bare day or its loaded one.

    Attributes:
        robot: With true inertials.
        coulomb: (n,).
        viscous: (n,).
        stribeck: (n,) share of Coulomb friction.
        speed: (n,) of the Stribeck term.
        load_friction: (n,) share of what a gear carries.
        offset: (n,) of the torque, none if not given [N m or N].
    """

    robot: Robot
    coulomb: Float[ndarray, " joints"]
    viscous: Float[ndarray, " joints"]
    stribeck: Float[ndarray, " joints"]
    speed: Float[ndarray, " joints"]
    load_friction: Float[ndarray, " joints"]
    offset: Float[ndarray, " joints"] | float = 0.0

    @classmethod
    def draw(cls, arm: CarryingArm, rng: np.random.Generator) -> TrueArm:
        """An arm of the kind."""
        n = arm.robot.n
        scale = np.repeat(1 + LINK_SPREAD * rng.standard_normal(n), 10)
        factors = np.exp(FRICTION_SPREAD * rng.standard_normal((2, n)))
        return cls(
            arm.robot.with_parameters(arm.robot.parameters * scale),
            np.array(arm.coulomb) * factors[0],
            np.array(arm.viscous) * factors[1],
            rng.uniform(*STRIBECK[0], n),
            rng.uniform(*STRIBECK[1], n),
            rng.uniform(*LOAD_FRICTION, n),
        )

    def another_day(self, rng: np.random.Generator, *, drift: float = 0.0) -> TrueArm:
        """With friction of another temperature.

        Args:
            rng: Source of what changes.
            drift: Of the torque's offset since the other day, as a share of Coulomb friction.
        """
        n = self.robot.n
        coulomb, viscous = 1 + DAY_SPREAD * rng.standard_normal((2, n))
        offset = self.offset
        if drift:
            offset = offset + drift * self.coulomb * rng.standard_normal(n)
        return dataclasses.replace(
            self, coulomb=self.coulomb * coulomb, viscous=self.viscous * viscous, offset=offset
        )

    def holding(self, frame: AttachedFrame, body: Float[ndarray, "10"]) -> TrueArm:
        """With a body that is held at a frame.

        Args:
            frame: Of the arm.
            body: Its parameters about that frame.
        """
        parameters = self.robot.parameters.copy()
        own = slice(10 * frame.joint, 10 * frame.joint + 10)
        parameters[own] += transform_parameters(body, frame.R_JF, frame.p_JF)
        return dataclasses.replace(self, robot=self.robot.with_parameters(parameters))

    def torque(self, motion: Motion) -> Float[ndarray, "samples joints"]:
        """Of every joint, without noise [N m or N]."""
        rigid = drake_torque(self.robot, motion)
        sign = np.tanh(motion.dq / SIGN)
        slow = self.stribeck * np.exp(-((motion.dq / self.speed) ** 2))
        return (
            rigid
            + self.coulomb * (1 + slow) * sign
            + self.viscous * motion.dq
            + self.load_friction * np.abs(rigid) * sign
            + self.offset
        )


def draw_load(rng: np.random.Generator) -> Float[ndarray, "10"]:
    """A box of even density somewhere at the flange: its ten parameters about that frame."""
    mass = float(np.exp(rng.uniform(*np.log(MASSES))))
    sides = rng.uniform(*SIZES, 3)
    aside, away = OFFSETS
    centre = np.append(rng.uniform(-aside, aside, 2), rng.uniform(0.0, away))
    R = Rotation.random(rng=rng).as_matrix()
    moments = mass / 12 * (np.sum(sides**2) - sides**2)
    box = np.concatenate([[mass], np.zeros(3), np.diag(moments)[np.triu_indices(3)]])
    return transform_parameters(box, R, centre)


def random_motion_of(
    arm: CarryingArm, seconds: float, rng: np.random.Generator, *, speed: float = 1.0
) -> Motion:
    """A random Fourier motion within the arm's limits.

    Args:
        arm: Whose limits hold.
        seconds: Its length.
        rng: Source of every draw.
        speed: Share of the speed at which it is played.
    """
    motion = random_fourier_motion(
        arm.robot.limits, seconds * speed, arm.highest, PERIOD * speed, rng
    )
    return Motion(motion.t / speed, motion.q, speed * motion.dq, speed**2 * motion.ddq)


def record(
    arm: CarryingArm,
    true: TrueArm,
    motion: Motion,
    rng: np.random.Generator,
    *,
    coloured: bool,
    name: str,
) -> DataSet:
    """What a laboratory would have logged of a motion.

    Args:
        arm: What is declared.
        true: What there is.
        motion: That it goes through.
        rng: Source of noise and of the encoders' jitter.
        coloured: Whether the noise of the torque is.
        name: Of the data set.
    """
    noise = rng.standard_normal(motion.q.shape)
    if coloured:
        noise = lfilter([np.sqrt(1 - COLOUR**2)], [1.0, -COLOUR], noise, axis=0)
    tau = true.torque(motion) + np.array(arm.noise) * noise
    jitter = 0.4 * rng.standard_normal(motion.q.shape)
    q = (np.floor(motion.q / ENCODER + jitter) + 0.5) * ENCODER
    recording = Recording(name, "estimation", motion.t, q, tau)
    return DataSet(name, "simulated", "CC0-1.0", arm.robot, "measured", recordings=(recording,))
