import dataclasses
import re

import numpy as np
import pytest

from oed.dynamics.effects import State
from studies.bench.case import Case
from studies.bench.excitation import random_fourier_motion
from studies.bench.forms import FORMS, OUTSIDE, WAVES
from studies.bench.make_dataset import make_dataset
from studies.bench.plan import TWO_JOINTS, plan
from studies.bench.robots import ROBOTS

STEP = 0.01  # [s]
COORDINATE = re.compile(r"(q|dq|ddq)_[1-9]|time|frequency|repetition")
# Of a round that was drawn when there were seven strangers.
PINNED = (
    ("outside", "vertical", "fanned_drag", "1", "white", "no", "1000"),
    ("pair", "scara", "position_friction+rotor", "1", "coloured", "yes", "1000"),
    ("size", "vertical", "spring", "0.25", "white", "no", "1000"),
    ("many_joints", "panda", "gain", "1", "white", "no", "1000"),
)
LATER = WAVES[1]
STRANGERS = sorted(key for key, form in FORMS.items() if form.name == OUTSIDE)


@pytest.fixture
def brief(monkeypatch):
    """The two-joint arms with motions of a few seconds."""
    for key in TWO_JOINTS:
        short = dataclasses.replace(ROBOTS[key], period=3.0, repetitions=2, single=4.0, highest=1.5)
        monkeypatch.setitem(ROBOTS, key, short)


def hide(key, robot, joint, tmp_path, *, seed=0, size=1.0):
    """The plain arm, what hiding gives, and a motion."""
    declared = ROBOTS[robot].declared(tmp_path)
    arm = ROBOTS[robot].arm(declared, np.random.default_rng(seed))
    injected = FORMS[key].inject(arm, joint, size, np.random.default_rng(seed + 1))
    rng = np.random.default_rng(seed + 2)
    return arm, injected, random_fourier_motion(declared.limits, 60.0, 0.7, STEP, rng)


def hidden_torque(injected, joint, motion):
    """At every sample, its memory carried on from one to the next [N m]."""
    state = State(motion.t, list(motion.q.T), list(motion.dq.T), list(motion.ddq.T))
    torque = np.zeros(len(motion.t))
    for extra in injected.arm.extra:
        torque += extra(state, [0.0] * motion.q.shape[1])[joint]
    for piece in injected.arm.memory:
        memory = np.zeros((len(motion.t), piece.states))
        for k in range(len(motion.t) - 1):
            now = State(motion.t[k], list(motion.q[k]), list(motion.dq[k]), list(motion.ddq[k]))
            memory[k + 1] = memory[k] + STEP * np.array(piece.rate(now, list(memory[k])))
        torque += piece.torque(state, list(memory.T))[joint]
    return torque


def joints_of(key):
    return (0,) if FORMS[key].has_outer else (0, 1)


def test_there_are_fourteen_strangers_and_half_of_them_came_later():
    assert len(STRANGERS) == 14
    assert len(LATER) == 7
    assert set(STRANGERS) > LATER


@pytest.mark.parametrize("robot", TWO_JOINTS)
@pytest.mark.parametrize("key", sorted(LATER))
def test_a_later_stranger_is_as_large_as_a_part_of_the_dry_friction(key, robot, tmp_path):
    for joint in joints_of(key):
        arm, injected, motion = hide(key, robot, joint, tmp_path)
        rms = np.sqrt(np.mean(hidden_torque(injected, joint, motion) ** 2))
        assert 0.1 < rms / arm.coulomb[joint] < 0.9


@pytest.mark.parametrize("key", sorted(LATER))
def test_a_later_stranger_grows_with_its_size_and_follows_from_its_draws(key, tmp_path):
    motion = hide(key, "scara", 0, tmp_path)[2]
    once, again, twice = (
        hidden_torque(hide(key, "scara", 0, tmp_path, size=size)[1], 0, motion)
        for size in (1.0, 1.0, 2.0)
    )
    np.testing.assert_array_equal(once, again)
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-9, atol=1e-12)
    other = hide(key, "scara", 0, tmp_path, seed=7)[1]
    assert not np.allclose(hidden_torque(other, 0, motion), once)


@pytest.mark.parametrize("key", STRANGERS)
def test_the_coordinates_of_a_stranger_are_those_of_the_arm(key, tmp_path):
    for robot in TWO_JOINTS:
        for joint in joints_of(key):
            sets = hide(key, robot, joint, tmp_path)[1].coordinates
            assert sets
            assert len(set(sets)) == len(sets)
            for names in sets:
                assert names == tuple(sorted(set(names)))
                assert all(COORDINATE.fullmatch(name) for name in names)
                assert all(int(n[-1]) <= 2 for n in names if n[-1].isdigit())


@pytest.mark.parametrize("key", sorted(LATER))
def test_a_later_stranger_shows_in_a_data_set_at_its_joint(key, brief, tmp_path):
    case = Case("outside", "vertical", (key,), 1.0, "white", True, 4)
    truth = make_dataset(case, tmp_path / "data")
    (hidden,) = truth.hidden
    assert (hidden.name, hidden.kind, hidden.form) == (OUTSIDE, OUTSIDE, key)
    assert np.argmax(np.array(truth.excess) / truth.noise) == hidden.joint
    assert 0.3 < truth.size_in_noise < 8


def test_a_flywheel_behind_a_crank_keeps_the_energy_that_it_is_given(tmp_path):
    _, injected, motion = hide("connecting_rod", "vertical", 0, tmp_path)
    (extra,) = injected.arm.extra

    def torque(q, dq, ddq):
        return extra(State(0.0, [q, 0.0], [dq, 0.0], [ddq, 0.0]), [0.0, 0.0])[0]

    q, dq, ddq = (x[:, 0] for x in (motion.q, motion.dq, motion.ddq))
    inertia = torque(q, 0.0, 1.0)
    energy = inertia * dq**2 / 2
    assert np.all(inertia >= 0)
    np.testing.assert_allclose(
        np.gradient(energy, STEP)[1:-1],
        (torque(q, dq, ddq) * dq)[1:-1],
        atol=0.02 * np.abs(torque(q, dq, ddq) * dq).max(),
    )


def test_later_strangers_leave_the_cases_of_a_round_as_they_were():
    cases = plan(1, first=1000)
    earlier = {case.key for case in cases if WAVES[0].issuperset(case.hidden)}
    assert len(cases) == len(earlier) + sum(len(wave) for wave in WAVES[1:])
    assert earlier.issuperset(PINNED)


def test_over_two_rounds_each_later_stranger_is_asked_of_both_arms():
    asked = {(c.hidden[0], c.robot) for c in plan(2, ("outside",)) if c.hidden[0] in LATER}
    assert asked == {(key, robot) for key in LATER for robot in TWO_JOINTS}
