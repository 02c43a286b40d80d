"""Arms that carry something, for studies: their torques by Drake, with friction that no model declares.

Along a random motion the rigid-body torque of arm and load is Drake's inverse dynamics. Added are Coulomb
and viscous friction, which changes from the bare day to the loaded one; a Stribeck term, which no model
declares; friction that grows with what the gears carry; and noise, white or coloured. Positions are read
by encoders with steps.
"""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from oed.dynamics.drake_plant import drake_torque
from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.robot import Robot, load_robot
from oed.robot.attached_frame import AttachedFrame, find_frame
from oed.robot.inertia import transform_parameters
from studies.bench.excitation import random_fourier_motion
from studies.bench.robots import ROBOTS
from studies.data_folders import EXAMPLE_ROBOTS

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
# A four-axis arm for assembly, after the data sheets of 600 mm arms.
SCARA = """
convention = "standard"
angles = "deg"
[[joint]]
a = 0.325
alpha = 0.0
d = 0.2
theta = 0.0
name = "arm_1"
lower = -130
upper = 130
velocity = 200
mass = 6.0
com = [-0.15, 0.0, 0.0]
inertia = [0.02, 0.0, 0.0, 0.08, 0.0, 0.09]
[[joint]]
a = 0.275
alpha = 180.0
d = 0.0
theta = 0.0
name = "arm_2"
lower = -140
upper = 140
velocity = 250
mass = 5.0
com = [-0.12, 0.0, 0.0]
inertia = [0.02, 0.0, 0.0, 0.05, 0.0, 0.05]
[[joint]]
kind = "prismatic"
a = 0.0
alpha = 0.0
d = 0.0
theta = 0.0
name = "quill"
lower = 0.0
upper = 0.2
velocity = 1.1
mass = 1.2
com = [0.0, 0.0, -0.08]
inertia = [0.004, 0.0, 0.0, 0.004, 0.0, 0.0006]
[[joint]]
a = 0.0
alpha = 0.0
d = 0.0
theta = 0.0
name = "turn"
lower = -350
upper = 350
velocity = 600
mass = 0.5
com = [0.0, 0.0, -0.02]
inertia = [0.0005, 0.0, 0.0, 0.0005, 0.0, 0.0003]
"""


@dataclass(frozen=True)
class CarryingArm:
    """An arm of the studies.

    Attributes:
        key: Its name.
        load: Gives the robot, as its file has it.
        coulomb: (n,) [N m or N].
        viscous: (n,) [N m s/rad or N s/m].
        noise: (n,) standard deviation of the torque [N m or N].
        highest: Frequency up to which the motion has harmonics [Hz].
    """

    key: str
    load: Callable[[], Robot]
    coulomb: tuple[float, ...]
    viscous: tuple[float, ...]
    noise: tuple[float, ...]
    highest: float = 0.6

    @property
    def robot(self) -> Robot:
        """As its file has it."""
        return _loaded(self.key)

    @property
    def frame(self) -> AttachedFrame:
        """Where it holds a load."""
        return find_frame(self.robot)


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
    """

    robot: Robot
    coulomb: Float[ndarray, " joints"]
    viscous: Float[ndarray, " joints"]
    stribeck: Float[ndarray, " joints"]
    speed: Float[ndarray, " joints"]
    load_friction: Float[ndarray, " joints"]

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

    def another_day(self, rng: np.random.Generator) -> TrueArm:
        """With friction of another temperature."""
        n = self.robot.n
        coulomb, viscous = 1 + DAY_SPREAD * rng.standard_normal((2, n))
        return dataclasses.replace(
            self, coulomb=self.coulomb * coulomb, viscous=self.viscous * viscous
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
        )


def draw_load(rng: np.random.Generator) -> Float[ndarray, "10"]:
    """A box of even density somewhere at the flange: its ten parameters about that frame."""
    mass = float(np.exp(rng.uniform(*np.log(MASSES))))
    sides = rng.uniform(*SIZES, 3)
    aside, away = OFFSETS
    centre = np.append(rng.uniform(-aside, aside, 2), rng.uniform(0.0, away))
    R = Rotation.random(random_state=rng).as_matrix()
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


def _scara() -> Robot:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scara.toml"
        path.write_text(SCARA, encoding="utf-8")
        robot = load_robot(path)
    acceleration = np.array([20.0, 25.0, 10.0, 60.0])  # [rad/s^2, m/s^2]
    bounds = np.stack([-acceleration, acceleration], axis=1)
    return robot.with_limits(robot.limits.with_(acceleration=bounds))


def _of_bench(key: str) -> Callable[[], Robot]:
    def load() -> Robot:
        with tempfile.TemporaryDirectory() as folder:
            return ROBOTS[key].declared(Path(folder))

    return load


def _ur10() -> Robot:
    robot = load_robot(EXAMPLE_ROBOTS / "ur_description/urdf/ur10_robot.urdf")
    n = robot.n
    return robot.with_limits(
        robot.limits.with_(
            position=np.array([[-2.8, 2.8], [-2.6, -0.5], [-2.2, 2.2], *[[-2.6, 2.6]] * 3]),
            velocity=np.tile([-2.0, 2.0], (n, 1)),
            acceleration=np.tile([-5.0, 5.0], (n, 1)),
        )
    )


def _as_of_bench(key: str) -> CarryingArm:
    bench = ROBOTS[key]
    return CarryingArm(
        key, _of_bench(key), bench.coulomb, bench.viscous, bench.noise, bench.highest
    )


ARMS = {
    arm.key: arm
    for arm in (
        _as_of_bench("ur5"),
        _as_of_bench("panda"),
        CarryingArm(
            "scara",
            _scara,
            coulomb=(3.0, 2.0, 12.0, 0.25),
            viscous=(2.0, 1.2, 40.0, 0.08),
            noise=(0.5, 0.3, 1.5, 0.03),
            highest=1.2,
        ),
        CarryingArm(
            "ur10",
            _ur10,
            coulomb=(12.0, 14.0, 9.0, 2.2, 2.0, 1.7),
            viscous=(15.0, 17.0, 11.0, 2.4, 2.1, 1.8),
            noise=(1.0, 1.2, 0.8, 0.2, 0.17, 0.15),
        ),
    )
}


@cache
def _loaded(key: str) -> Robot:
    return ARMS[key].load()
