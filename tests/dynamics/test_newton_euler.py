"""The recursion and its regressor against closed form, Drake and Pinocchio."""

import dataclasses
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from oed.dynamics.cross_check import cross_check
from oed.dynamics.energy import energy_regressor
from oed.dynamics.motion import Motion, random_motion
from oed.dynamics.newton_euler import rigid_body_regressor, rigid_body_torque
from oed.dynamics.planar import planar_regressor
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot, arm_joints, imi_scara, load_robot
from oed.robot.builtin import IMI_BASE_PARAMETERS, IMI_LINK_LENGTHS
from studies.data_folders import EXAMPLE_ARMS
from tests.paths import example_robot


def _arm(name: str) -> Robot:
    path = example_robot(name)
    return load_robot(path, joints=arm_joints(path))


@pytest.mark.parametrize("name", EXAMPLE_ARMS)
def test_torques_are_drakes(name: str) -> None:
    check = cross_check(_arm(name), states=50)
    assert check.agrees, check


def test_a_tree_of_48_joints_agrees_with_drake() -> None:
    robot = load_robot(example_robot("tiago_description/robots/tiago.urdf"))
    assert robot.n == 48
    assert cross_check(robot, states=10).agrees


def test_a_bent_arm_agrees_with_drake_and_pinocchio_where_joints_are_held() -> None:
    file = example_robot("ur_description/urdf/ur5_robot.urdf")
    first, second, elbow, *_ = load_robot(file).joint_names
    robot = load_robot(file, joints=[first, second], locked={elbow: 1.2})
    check = cross_check(robot, states=10)
    assert check.agrees
    assert check.pinocchio is not None


def test_any_gravity_agrees_with_drake() -> None:
    robot = _arm("ur_description/urdf/ur5_robot.urdf").with_gravity(np.array([3.0, -5.0, 2.0]))
    assert cross_check(robot, states=20).agrees


@pytest.mark.parametrize(
    "name", ["ur_description/urdf/ur5_robot.urdf", "panda_description/urdf/panda.urdf"]
)
def test_regressor_is_pinocchios(name: str) -> None:
    path = example_robot(name)
    robot = load_robot(path)
    model = pinocchio.buildModelFromUrdf(str(path))
    held = [model.getJointId(name) for name in robot.locked]  # the finger that mimics the other
    model = pinocchio.buildReducedModel(model, held, pinocchio.neutral(model))
    data = model.createData()
    motion = random_motion(robot, 20, np.random.default_rng(4))
    # Pinocchio orders m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz in the same joint frames.
    order = np.array([0, 1, 2, 3, 4, 5, 7, 6, 8, 9])
    columns = np.concatenate([10 * i + order for i in range(robot.n)])
    assert list(model.names)[1:] == list(robot.joint_names)
    ours = rigid_body_regressor(robot, motion)[:, :, columns]
    for k in range(len(motion)):
        theirs = pinocchio.computeJointTorqueRegressor(
            model, data, motion.q[k], motion.dq[k], motion.ddq[k]
        )
        assert np.abs(ours[k] - theirs).max() < 1e-11 * np.abs(theirs).max()


def test_the_scara_is_the_papers_closed_form() -> None:
    robot = imi_scara()
    motion = random_motion(robot, 100, np.random.default_rng(5))
    closed = planar_regressor(motion, IMI_LINK_LENGTHS[0])
    torque = closed[:, :, :4] @ np.array(IMI_BASE_PARAMETERS)
    assert np.abs(rigid_body_torque(robot, motion) - torque).max() < 1e-12 * np.abs(torque).max()
    friction = TorqueModel.standard(robot).columns(motion)[:, :, 20:]
    assert np.array_equal(friction, closed[:, :, 4:])


def test_the_change_of_energy_is_the_power_of_the_torque() -> None:
    robot = load_robot(example_robot("panda_description/urdf/panda.urdf"))
    motion = random_motion(robot, 20, np.random.default_rng(6))
    step = 1e-5  # [s]; the central difference errs by step^2 = 1e-10
    after, before = (_advanced(motion, h) for h in (step, -step))
    rate = (energy_regressor(robot, after) - energy_regressor(robot, before)) / (2 * step)
    power = np.einsum("kj,kjc->kc", motion.dq, rigid_body_regressor(robot, motion))
    assert np.abs(rate - power).max() < 1e-8 * np.abs(power).max()


def test_a_prismatic_joint_lifts_its_weight() -> None:
    robot = imi_scara()
    lift = dataclasses.replace(robot.joints[0], kind="prismatic")
    robot = dataclasses.replace(robot, joints=(lift, robot.joints[1]))
    still = Motion(np.zeros(1), np.zeros((1, 2)), np.zeros((1, 2)), np.array([[2.0, 0.0]]))
    mass = robot.parameters[0] + robot.parameters[10]
    assert rigid_body_torque(robot, still)[0, 0] == pytest.approx(mass * (9.81 + 2.0))


def test_a_file_with_rotor_inertias_is_compared_by_its_bodies(tmp_path: Path) -> None:
    # Drake adds them to its inverse dynamics: the files that `studies.feasible` leaves had failed.
    (tmp_path / "arm.xml").write_text("""<mujoco model="arm"><worldbody><body name="upper">
<joint name="swing" type="hinge" axis="0 1 0" armature="0.4"/>
<inertial pos="0.3 0 0" mass="2" diaginertia="0.01 0.02 0.02"/></body></worldbody>
<actuator><motor name="swing" joint="swing" gear="1"/></actuator></mujoco>""")
    assert cross_check(load_robot(tmp_path / "arm.xml"), states=20).agrees


def _advanced(motion: Motion, h: float) -> Motion:
    return Motion(
        motion.t,
        motion.q + h * motion.dq + h**2 / 2 * motion.ddq,
        motion.dq + h * motion.ddq,
        motion.ddq,
    )
