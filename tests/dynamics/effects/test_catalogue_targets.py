"""Where effects of the catalogue may sit, and what they know of one another."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects import State, TorqueOffset
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.context import Context
from oed.dynamics.torque_model import TorqueModel
from oed.robot import imi_scara
from tests.dynamics.effects.arms import panda, smooth_motion


def context_of(robot, beside=()):
    model = TorqueModel.standard(robot)
    parameters = np.zeros(len(model.parameters))
    return Context.of(model, parameters, [smooth_motion(robot)], beside=beside)


def test_a_motor_couples_neighbours_or_joints_of_a_wrist():
    coupling = CATALOGUE["motor_coupling"]
    assert set(coupling.targets(context_of(imi_scara()))) == {(0, 1), (1, 0)}
    targets = set(coupling.targets(context_of(panda())))
    neighbours = {(i, j) for i in range(7) for j in range(7) if abs(i - j) == 1}
    assert targets == neighbours | {(4, 6), (6, 4)}


def test_along_sliding_joints_a_tilt_is_an_offset_and_has_no_name_of_its_own():
    tilt, offset = CATALOGUE["gravity_direction"], CATALOGUE["torque_offset"]
    turning = imi_scara()
    sliding = dataclasses.replace(
        turning,
        joints=tuple(dataclasses.replace(joint, kind="prismatic") for joint in turning.joints),
    )
    assert tilt.targets(context_of(turning)) == (None,)
    assert tilt.targets(context_of(sliding)) == ()
    assert offset.targets(context_of(sliding)) == (0, 1)


@pytest.mark.parametrize("ratio", [0.0, 0.3])
def test_a_coupled_joint_has_in_its_row_the_friction_of_anothers_motor(ratio):
    robot = imi_scara()
    coupling = CATALOGUE["motor_coupling"].build(context_of(robot), (0, 1), (ratio, 2.0))
    motion = smooth_motion(robot)
    state = State(motion.t, *motion.components)
    _, viscous, _ = coupling.entries(state)
    speed = motion.dq[:, 1] + ratio * motion.dq[:, 0]
    if ratio == 0:
        assert set(viscous) == {0}
        assert np.asarray(viscous[0]) == pytest.approx(speed)
    else:
        assert np.asarray(viscous[0]) == pytest.approx(ratio * speed)
        assert np.asarray(viscous[1]) == pytest.approx(speed)


def test_the_torque_of_reference_holds_what_was_found_so_far():
    robot = imi_scara()
    offset = (TorqueOffset(1), np.array([0.7]))
    motion = smooth_motion(robot)
    state = State(motion.t, *motion.components)
    bare, known = (context_of(robot, b).reference.total(state) for b in ((), (offset,)))
    assert np.allclose(np.asarray(known[1]) - np.asarray(bare[1]), 0.7, atol=1e-12)
    assert np.allclose(np.asarray(known[0]), np.asarray(bare[0]), atol=1e-12)


def reason_against(ratio, *estimates):
    """Why inertia, viscous and Coulomb friction cannot be those of a motor of joints 5 and 7."""
    context = context_of(panda())
    return CATALOGUE["motor_coupling"].plausible(context, (4, 6), (ratio, 2.0), np.array(estimates))


def test_beside_a_motors_friction_its_inertia_may_be_noise():
    assert reason_against(1.0, -1e-5, 0.05, 0.04) is None
    assert "inertia is -1 kg m^2" in (reason_against(1.0, -1.0, 0.05, 0.04) or "")


def test_the_friction_of_a_motor_has_one_sign():
    assert reason_against(0.0, 0.0, 0.5, 0.1) is None
    assert reason_against(0.0, 0.0, -0.5, -0.1) is None
    assert "one sign" in (reason_against(0.0, 0.0, 0.5, -0.3) or "")
    # Beside an inertia that does far more, both parts may be noise.
    assert reason_against(0.0, 10.0, 0.5, -0.3) is None
