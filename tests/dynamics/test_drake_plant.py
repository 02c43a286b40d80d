import numpy as np
import pytest

from oed.dynamics.drake_plant import build_plant, drake_torque
from oed.dynamics.motion import random_motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.robot import Joint, JointLimits, Robot
from oed.robot.builtin import imi_scara
from oed.robot.inertia import parameters_from_pseudo_inertia


def random_tree(rng: np.random.Generator) -> Robot:
    """Five joints of both kinds on two branches, with consistent random inertias."""
    kinds = ("revolute", "prismatic", "revolute", "revolute", "prismatic")
    joints, parameters = [], []
    for i, parent in enumerate((-1, 0, 1, 0, 3)):
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        axis = rng.normal(size=3)
        root = rng.normal(size=(4, 4))
        joints.append(
            Joint(
                name=f"j{i}",
                kind=kinds[i],
                parent=parent,
                axis=axis / np.linalg.norm(axis),
                R_PJ=rotation * np.sign(np.linalg.det(rotation)),
                p_PJ=rng.normal(size=3),
                link=f"l{i}",
                R_LJ=np.eye(3),
                p_LJ=np.zeros(3),
            )
        )
        parameters.append(parameters_from_pseudo_inertia(root @ root.T + 0.1 * np.eye(4)))
    return Robot(
        "tree",
        tuple(joints),
        np.concatenate(parameters),
        np.array([1.0, -2.0, -9.0]),
        JointLimits.unlimited(5),
    )


@pytest.mark.parametrize("seed", range(3))
def test_torque_agrees_with_newton_euler_on_any_tree(seed):
    rng = np.random.default_rng(seed)
    robot = random_tree(rng)
    motion = random_motion(robot, 40, rng)
    ours = rigid_body_torque(robot, motion)
    assert np.abs(drake_torque(robot, motion) - ours).max() < 1e-10 * np.abs(ours).max()


def test_torque_agrees_on_the_scara():
    robot = imi_scara()
    motion = random_motion(robot, 40, np.random.default_rng(0))
    np.testing.assert_allclose(
        drake_torque(robot, motion), rigid_body_torque(robot, motion), atol=1e-11
    )


def test_refuses_a_body_without_mass():
    robot = imi_scara()
    parameters = robot.parameters.copy()
    parameters[10] = 0.0
    with pytest.raises(ValueError, match="joint_2"):
        build_plant(robot.with_parameters(parameters))
