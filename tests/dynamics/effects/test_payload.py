"""A payload is inertia added to the link that holds it, from its moment on."""

from pathlib import Path

import numpy as np
import pytest

from oed.dynamics.effects.entries.payload import visible_load
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.newton_euler import rigid_body_torque
from oed.dynamics.torque_model import TorqueModel
from oed.robot import load_robot
from tests.dynamics.effects.arms import panda, scara, smooth_motion, vertical_arm

BODY = """<link name="{0}"><inertial><mass value="2"/><origin xyz="0.1 0 0.02"/>
<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>
<origin xyz="{3}"/><axis xyz="{4}"/><limit lower="-2" upper="2" velocity="5" effort="50"/></joint>"""
PAN_TILT = (
    '<robot name="head"><link name="base"/>'
    + BODY.format("neck")
    + BODY.format("camera")
    + JOINT.format("pan", "base", "neck", "0 0 0.2", "0 0 1")
    + JOINT.format("tilt", "neck", "camera", "0.05 0 0.15", "0 1 0")
    + "</robot>"
)


def test_a_load_is_inertia_added_to_the_link_from_a_moment_on() -> None:
    robot = panda()
    motion = smooth_motion(robot, step=0.02)
    load = np.array([1.2, 0.05, -0.02, 0.1, 0.02, 0.001, 0.0, 0.03, -0.002, 0.01])
    effect = PayloadChange(robot, 6, moment=4.0)
    added = TorqueModel(robot, (effect,)).torque(load, motion)
    loaded = robot.parameters.copy()
    loaded[60:70] += load
    difference = rigid_body_torque(robot.with_parameters(loaded), motion) - rigid_body_torque(
        robot, motion
    )
    held = motion.t >= 4.0
    assert added[held] == pytest.approx(difference[held], abs=1e-10)
    assert not added[~held].any()


def test_each_recording_starts_its_own_clock() -> None:
    robot = scara()
    motion = smooth_motion(robot, step=0.02)
    effect = PayloadChange(robot, 1, moment=4.0)
    later = type(motion)(motion.t + 1000.0, motion.q, motion.dq, motion.ddq)
    model = TorqueModel(robot, (effect,))
    assert model.columns(later) == pytest.approx(model.columns(motion))


def test_a_load_may_be_put_down_again() -> None:
    robot = scara()
    motion = smooth_motion(robot, step=0.02)
    for_a_while = PayloadChange(robot, 1, 4.0, held_for=2.5)
    assert np.array_equal(for_a_while.held(motion.t), (motion.t >= 4.0) & (motion.t < 6.5))


@pytest.mark.parametrize(
    ("arm", "names"),
    [(scara, ("m", "mx", "my", "Izz")), (vertical_arm, ("m", "mx", "my", "Izz"))],
)
def test_planar_load_shows_four_parameters(arm, names: tuple[str, ...]) -> None:
    robot = arm()
    kept = visible_load(robot, 1).kept
    assert tuple(robot.parameter_names[10 + k].split("_")[0] for k in kept) == names


def test_a_spatial_load_shows_all_ten() -> None:
    seen = visible_load(panda(), 6)
    assert seen.kept == tuple(range(10))
    assert seen.regrouping == pytest.approx(np.eye(10), abs=1e-9)


def test_a_mass_that_no_motion_tells_from_inertia_is_part_of_it(tmp_path: Path) -> None:
    """A pan-tilt head: the second axis at 50 mm from the first, which is vertical."""
    path = tmp_path / "head.urdf"
    path.write_text(PAN_TILT)
    robot = load_robot(path)
    seen = visible_load(robot, 1)
    assert 0 not in seen.kept
    izz = seen.kept.index(9)
    assert "m_2" in seen.expressions[izz]
    # A load's torque is that of what it stands for.
    motion = smooth_motion(robot, step=0.02)
    load = np.array([0.3, 0.04, 0.003, 0.006, 0.002, 1e-4, 2e-4, 0.008, 3e-4, 0.007])
    whole = TorqueModel(robot, (PayloadChange(robot, 1, moment=0.0),))
    part = TorqueModel(robot, (PayloadChange(robot, 1, moment=0.0, kept=seen.kept),))
    assert part.torque(seen.regrouping @ load, motion) == pytest.approx(
        whole.torque(load, motion), abs=1e-9
    )
