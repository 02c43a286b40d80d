"""What a headline must not leave out: names that nothing tells apart, joints that are predicted badly."""

import numpy as np

from oed.diagnosis.inference.answer import Alternative, FoundEffect
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.report.doubts import far_off, names_of


def _found(name, joint, *alternatives):
    page = CATALOGUE[name].page
    return FoundEffect(name, joint, 0, 1.0, (), alternatives, 9.0, 3.0, page)


def test_names_that_give_the_same_torque_are_said_in_one_breath():
    lag = _found(
        "filter_lag",
        None,
        Alternative("time_delay", "time_delay", None, 0.56, same=True, open=True),
        Alternative("f(q_1)[11]@1", "smooth term", 0, 0.1, same=True, open=True),
        Alternative("stribeck@1", "stribeck", 0, 0.1, same=False, open=True),
        Alternative("torque_offset@2", "torque_offset", 1, 1e-6, same=True, open=False),
    )
    assert names_of(lag) == "filter_lag or time_delay (arm)"
    offset = Alternative("torque_offset@2", "torque_offset", 1, 0.12, same=True, open=True)
    tilt = _found("gravity_direction", None, offset)
    assert names_of(tilt) == "gravity_direction (arm) or torque_offset (joint 2)"
    assert names_of(_found("stribeck", 1)) == "stribeck (joint 2)"


def test_joints_above_two_noise_floors_are_named_though_the_mean_is_good():
    floor = np.array([0.5, 0.1, 2.0])
    assert far_off(np.array([0.5, 0.19, 2.0]), floor) == ""
    assert far_off(np.array([0.5, 0.57, 2.0]), floor) == "; above 2 noise floors: joint 2 (5.7)"
