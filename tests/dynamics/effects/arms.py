"""Arms, parameters and smooth motions that the tests of effects share."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot, imi_scara, load_robot
from oed.robot.load import arm_joints
from tests.paths import example_robot

BASE_FREQUENCY = 0.2  # [Hz]


def scara() -> Robot:
    return imi_scara()


def vertical_arm() -> Robot:
    """The SCARA on its side: gravity acts in its plane."""
    return imi_scara().with_gravity(np.array([0.0, -9.81, 0.0]))


def panda() -> Robot:
    path = example_robot("panda_description/urdf/panda.urdf")
    return load_robot(path, joints=arm_joints(path))


def smooth_motion(robot: Robot, duration: float = 10.0, step: float = 2e-3) -> Motion:
    """Three harmonics a joint, of different phase, through rest and reversals."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, duration, step)
    q, dq, ddq = (np.zeros((len(t), robot.n)) for _ in range(3))
    for k in (1, 2, 3):
        w = 2 * np.pi * BASE_FREQUENCY * k
        amplitude, phase = rng.uniform(0.2, 0.5, robot.n), rng.uniform(0, 2 * np.pi, robot.n)
        angle = w * t[:, None] + phase
        q += amplitude / k * np.sin(angle)
        dq += amplitude / k * w * np.cos(angle)
        ddq -= amplitude / k * w**2 * np.sin(angle)
    return Motion(t, q, dq, ddq)


def parameters_of(model: TorqueModel) -> Float[ndarray, " parameters"]:
    """The robot's own inertia, and round numbers for friction."""
    friction = {"Fc": 2.0, "Fv": 1.0}
    rest = [friction[p.name[:2]] for p in model.parameters[10 * model.robot.n :]]
    return np.concatenate([model.robot.parameters, rest])


def context_of(robot: Robot, motion: Motion | None = None) -> Context:
    model = TorqueModel.standard(robot)
    motion = smooth_motion(robot) if motion is None else motion
    return Context.of(model, parameters_of(model), [motion])
