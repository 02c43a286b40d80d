"""Arms with known parameters and torques computed from them."""

import functools

import numpy as np

from oed.dynamics.models import build_model
from oed.dynamics.motion import random_motion
from oed.estimation.feasible.data_factor import DataFactor, JointFactors
from oed.robot import Joint, JointLimits, Robot, load_robot
from oed.robot.inertia import parameters_from_pseudo_inertia
from tests.paths import example_robot

UR5 = "ur_description/urdf/ur5_robot.urdf"


@functools.cache
def ur5_model():
    return build_model("rotor", load_robot(example_robot(UR5)))


@functools.cache
def small_model():
    """Three joints, thirty inertial parameters and three effects a joint."""
    return build_model("rotor", random_tree(3, np.random.default_rng(42), branching=False))


def random_body(rng, size=0.1):
    """A body of random points of mass: consistent by construction."""
    points = np.column_stack([rng.normal(0.0, size, (12, 3)), np.ones(12)])
    masses = rng.uniform(0.05, 0.3, 12)
    return parameters_from_pseudo_inertia(np.einsum("k,ki,kj->ij", masses, points, points))


def random_tree(joints, rng, branching=True):
    """A tree with random frames, every third body carrying two more."""
    made = []
    for i in range(joints):
        rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        rotation[:, 0] *= np.sign(np.linalg.det(rotation))
        parent = i - 1 if not branching or i % 3 else i // 2 - 1
        made.append(
            Joint(
                name=f"joint_{i + 1}",
                kind="prismatic" if i % 7 == 4 else "revolute",
                parent=max(parent, -1),
                axis=np.array([0.0, 0.0, 1.0]),
                R_PJ=rotation,
                p_PJ=rng.normal(0.0, 0.2, 3),
                link=f"link_{i + 1}",
                R_LJ=np.eye(3),
                p_LJ=np.zeros(3),
            )
        )
    return Robot(
        name="tree",
        joints=tuple(made),
        parameters=np.concatenate([random_body(rng) for _ in range(joints)]),
        gravity=np.array([0.0, 0.0, -9.81]),
        limits=JointLimits.unlimited(joints),
    )


def true_parameters(model, rng):
    """The robot's own bodies, with friction and rotors between a half and two."""
    effects = len(model.parameters) - 10 * model.robot.n
    return np.concatenate([model.robot.parameters, rng.uniform(0.5, 2.0, effects)])


def joints_of(model, truth, rng, *, samples=100, noise=0.0):
    """The same by joint, unweighted."""
    motion = random_motion(model.robot, samples, rng)
    torque = model.torque(truth, motion)
    torque = torque + noise * rng.standard_normal(torque.shape)
    return JointFactors.of(model.columns(motion), torque)


def data_of(model, truth, rng, *, samples=100, noise=0.0):
    """Factor of torques at random states, weighted by one."""
    motion = random_motion(model.robot, samples, rng)
    torque = model.torque(truth, motion)
    torque = torque + noise * rng.standard_normal(torque.shape)
    variances = np.full(model.robot.n, max(noise, 1.0) ** 2)
    return DataFactor.of(model.regressor(motion), torque, variances)
