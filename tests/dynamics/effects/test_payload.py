"""A payload is inertia added to the link that holds it, from its moment on."""

import numpy as np
import pytest

from oed.dynamics.effects.entries.history import visible_load_parameters
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.newton_euler import rigid_body_torque
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import panda, scara, smooth_motion, vertical_arm


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


@pytest.mark.parametrize(
    ("arm", "names"),
    [(scara, ("m", "mx", "my", "Izz")), (vertical_arm, ("m", "mx", "my", "Izz"))],
)
def test_planar_load_shows_four_parameters(arm, names: tuple[str, ...]) -> None:
    robot = arm()
    kept = visible_load_parameters(robot, 1)
    assert tuple(robot.parameter_names[10 + k].split("_")[0] for k in kept) == names


def test_a_spatial_load_shows_all_ten() -> None:
    assert visible_load_parameters(panda(), 6) == tuple(range(10))
