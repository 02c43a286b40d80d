"""Every joint gets finite limits, within what its file says, and every assumption is said."""

from __future__ import annotations

import numpy as np
import pytest

from oed.design.default_limits import with_default_limits
from oed.robot import JointLimits, Robot, imi_scara, load_robot

INF = np.inf


def limited(**bounds: list[list[float]]) -> Robot:
    given = {kind: np.array(bound) for kind, bound in bounds.items()}
    return imi_scara().with_limits(JointLimits.unlimited(2).with_(**given))


def test_limits_that_are_given_stay_without_a_note() -> None:
    robot = limited(
        position=[[-1.0, 2.0], [0.5, 0.7]],
        velocity=[[-1.0, 3.0], [-2.0, 0.5]],
        acceleration=[[-4.0, 5.0], [-60.0, 70.0]],
        torque=[[-1.0, 1.0], [-INF, INF]],
    )
    found, notes = with_default_limits(robot)
    assert notes == ()
    for kind in ("position", "velocity", "acceleration", "torque", "jerk"):
        np.testing.assert_array_equal(getattr(found.limits, kind), getattr(robot.limits, kind))


def test_all_that_is_missing_is_finite_and_noted() -> None:
    found, notes = with_default_limits(limited())
    np.testing.assert_allclose(found.limits.position, [[-np.pi, np.pi]] * 2)
    for kind in ("position", "velocity", "acceleration"):
        assert np.isfinite(getattr(found.limits, kind)).all()
        for name in found.joint_names:
            assert sum(note.startswith(f"{kind} of {name}:") for note in notes) == 1
    assert len(notes) == 6


def test_two_turns_are_a_range_and_more_are_none() -> None:
    turn = 2 * np.pi
    found, notes = with_default_limits(limited(position=[[-turn, turn], [-turn - 0.1, turn + 0.1]]))
    np.testing.assert_allclose(found.limits.position, [[-turn, turn], [-np.pi, np.pi]])
    assert [note for note in notes if note.startswith("position")] == [
        "position of joint_2: its limits are more than two turns apart, assumed within -3.142 ... 3.142 rad"
    ]


@pytest.mark.parametrize(
    "given", [[0.0, INF], [-INF, 0.0], [4.0, INF], [-INF, -9.0], [0.0, 20.0], [-1.0, INF]]
)
def test_an_assumed_position_keeps_the_bounds_that_are_given(given: list[float]) -> None:
    found, notes = with_default_limits(limited(position=[given, [-1.0, 1.0]]))
    lower, upper = found.limits.position[0]
    assert given[0] <= lower
    assert upper <= given[1]
    assert upper - lower == pytest.approx(2 * np.pi)
    assert any(note.startswith("position of joint_1") for note in notes)


def test_an_assumed_rate_keeps_the_side_that_is_given() -> None:
    found, notes = with_default_limits(
        limited(velocity=[[-0.5, INF], [-INF, 7.0]], acceleration=[[-INF, 3.0], [-1.0, INF]])
    )
    assert found.limits.velocity[0].tolist() == [-0.5, 0.5]
    assert found.limits.velocity[1, 1] == 7.0
    assert -7.0 <= found.limits.velocity[1, 0] < 0.0
    assert found.limits.acceleration[0, 1] == 3.0
    assert -3.0 <= found.limits.acceleration[0, 0] < 0.0
    assert found.limits.acceleration[1].tolist() == [-1.0, 1.0]
    assert sum("velocity" in note for note in notes) == 2


def test_a_slow_joint_is_not_assumed_to_accelerate_like_a_fast_one() -> None:
    found, _ = with_default_limits(limited(velocity=[[-0.1, 0.1], [-9.0, 9.0]]))
    slow, fast = found.limits.acceleration[:, 1]
    # From rest to the velocity limit in a fifth of a second, but 15 rad/s^2 at most.
    assert slow == pytest.approx(0.5)
    assert fast == pytest.approx(15.0)


def test_a_slider_is_assumed_to_travel_metres_not_turns(tmp_path) -> None:
    (tmp_path / "slider.urdf").write_text("""<robot name="s"><link name="a"/><link name="b"/>
<joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0" velocity="0" effort="0"/></joint></robot>""")
    found, notes = with_default_limits(load_robot(tmp_path / "slider.urdf"))
    np.testing.assert_allclose(found.limits.position, [[-0.5, 0.5]])
    assert len(notes) == 3
