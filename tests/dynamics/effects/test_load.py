"""Effects that grow with the torque, against the torque written out."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.effect import State
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.load import LoadFriction, TorqueSaturation
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import rigid_body_torque
from tests.dynamics.effects.arms import context_of, panda, smooth_motion, vertical_arm

ARM = vertical_arm()
MOTION = smooth_motion(ARM)
CONTEXT = context_of(ARM, MOTION)
RIGID = rigid_body_torque(ARM, MOTION)
TOTAL = RIGID + 2.0 * np.sign(MOTION.dq) + 1.0 * MOTION.dq


def test_reference_is_the_model_with_its_parameters() -> None:
    for robot in (ARM, panda()):
        motion = smooth_motion(robot, step=0.05)
        context = context_of(robot, motion)
        expected = context.model.torque(context.parameters, motion)
        parts = context.reference.parts(motion)
        assert parts.sum(axis=2) == pytest.approx(expected, abs=1e-10)
        assert parts[:, :, 0] == pytest.approx(rigid_body_torque(robot, motion), abs=1e-10)


def test_reference_inertia_is_the_diagonal_of_the_inertia_matrix() -> None:
    c = np.cos(MOTION.q[:, 1])
    total, first_x, first_y, inertia_2 = 3.923, 0.808, 0.328, 0.141
    coupling = 2 * 0.359 * (first_x * c - first_y * np.sin(MOTION.q[:, 1]))
    state = State(MOTION.t, *MOTION.components)
    assert CONTEXT.reference.inertia(state, 0) == pytest.approx(total + inertia_2 + coupling)
    assert CONTEXT.reference.inertia(state, 1) == pytest.approx(inertia_2)


def test_reference_remembers_without_mixing_motions_up() -> None:
    other = smooth_motion(ARM, duration=10.0, step=2.5e-3)
    reference = CONTEXT.reference
    for motion in (MOTION, other, MOTION, MOTION[:100], other):
        expected = CONTEXT.model.torque(CONTEXT.parameters, motion)
        assert reference.parts(motion).sum(axis=2) == pytest.approx(expected, abs=1e-10)


def test_reference_refuses_a_vector_of_another_model() -> None:
    with pytest.raises(ValueError, match="3 values for a model of 24"):
        ReferenceTorque.of(ARM, CONTEXT.model.effects, np.zeros(3))


@pytest.mark.parametrize(("share", "load"), [(0.0, RIGID), (1.0, TOTAL)])
def test_load_friction_follows_either_load(share: float, load: np.ndarray) -> None:
    column = evaluate(LoadFriction(1, CONTEXT.reference, share), MOTION, 2)[:, 1, 0]
    assert column == pytest.approx(np.abs(load[:, 1]) * np.sign(MOTION.dq[:, 1]), abs=1e-10)


def test_load_friction_may_grow_faster_than_the_load() -> None:
    friction = LoadFriction(1, CONTEXT.reference, 1.0, peak=8.0)
    columns = evaluate(friction, MOTION, 2)[:, 1]
    direction = np.sign(MOTION.dq[:, 1])
    expected = np.stack([np.abs(TOTAL[:, 1]) * direction, TOTAL[:, 1] ** 2 / 8.0 * direction], 1)
    assert columns == pytest.approx(expected, abs=1e-10)
    with pytest.raises(ValueError, match="peak"):
        LoadFriction(1, CONTEXT.reference, peak=0.0)


def test_a_gear_may_lose_less_where_its_load_drives_it() -> None:
    columns = evaluate(LoadFriction(1, CONTEXT.reference, by_power=True), MOTION, 2)[:, 1]
    friction = np.abs(RIGID[:, 1]) * np.sign(MOTION.dq[:, 1])
    drives = RIGID[:, 1] * MOTION.dq[:, 1] > 0
    assert 0.1 < drives.mean() < 0.9
    expected = np.stack([np.where(drives, friction, 0), np.where(drives, 0, friction)], 1)
    assert columns == pytest.approx(expected, abs=1e-10)
    with pytest.raises(ValueError, match="power's way"):
        LoadFriction(1, CONTEXT.reference, peak=8.0, by_power=True)


@pytest.mark.parametrize(
    ("estimates", "plausible"),
    [([0.1, 0.02], True), ([0.1, -0.001], True), ([0.1, -0.1], False), ([-0.1, 0.1], False)],
)
def test_a_gear_gains_nothing_either_way(estimates: list[float], *, plausible: bool) -> None:
    entry = CATALOGUE["load_dependent_friction"]
    reason = entry.plausible(CONTEXT, 1, (0.0, 3.0), np.array(estimates))
    assert (reason is None) is plausible


@pytest.mark.parametrize(
    ("estimates", "plausible"),
    [([0.0, 0.1], True), ([-0.02, 0.1], True), ([-0.12, 0.2], False), ([0.2, -0.3], False)],
)
def test_load_friction_brakes_under_load(estimates: list[float], *, plausible: bool) -> None:
    entry = CATALOGUE["load_dependent_friction"]
    reason = entry.plausible(CONTEXT, 1, (0.0, 2.0), np.array(estimates))
    assert (reason is None) is plausible


@pytest.mark.parametrize(("share", "inertial"), [(-1.0, 0.0), (-0.25, 0.75)])
def test_of_a_load_the_weight_alone_may_count(share: float, inertial: float) -> None:
    arm = panda()
    motion = smooth_motion(arm, step=0.05)
    still = Motion(motion.t, motion.q, 0 * motion.dq, 0 * motion.ddq)
    weight, load = (rigid_body_torque(arm, m)[:, 3] for m in (still, motion))
    friction = LoadFriction(3, context_of(arm, motion).reference, share)
    column = evaluate(friction, motion, 7)[:, 3, 0]
    expected = np.abs(weight + inertial * (load - weight)) * np.sign(motion.dq[:, 3])
    assert column == pytest.approx(expected, abs=1e-9)


def test_saturation_takes_away_its_size_at_the_peak() -> None:
    peak = float(np.abs(TOTAL[:, 0]).max())
    column = evaluate(TorqueSaturation(0, CONTEXT.reference, peak, 3.0), MOTION, 2)[:, 0, 0]
    assert np.abs(column).max() == pytest.approx(1.0)
    assert column == pytest.approx(-((TOTAL[:, 0] / peak) ** 3), abs=1e-10)


def test_a_tanh_of_the_torque_is_saturation_too() -> None:
    peak = float(np.abs(TOTAL[:, 0]).max())
    limit = 1.5 * peak
    lost = limit * np.tanh(TOTAL[:, 0] / limit) - TOTAL[:, 0]
    column = evaluate(TorqueSaturation(0, CONTEXT.reference, peak, 3.0), MOTION, 2)[:, 0, 0]
    size = column @ lost / (column @ column)
    assert size > 0
    assert np.sum((lost - size * column) ** 2) < 0.01 * np.sum(lost**2)


def test_deep_saturation_follows_the_current_of_a_tanh() -> None:
    """What the current says is the inverse of a tanh, at three quarters of its limit."""
    peak = float(np.abs(TOTAL[:, 0]).max())
    limit = peak / 0.75
    added = limit * np.arctanh(TOTAL[:, 0] / limit) - TOTAL[:, 0]
    left = []
    for form in ("power", "series"):
        saturation = TorqueSaturation(0, CONTEXT.reference, peak, 3.0, form)
        columns = evaluate(saturation, MOTION, 2)[:, 0]
        sizes = np.linalg.lstsq(columns, added, rcond=None)[0]
        left.append(np.std(added - columns @ sizes) / np.std(added))
    # The series goes on with 1 / 7 of the 7th power: 0.75^4 * 3 / 7 of the first term is left to
    # be shared by two columns, and 0.75^2 * 3 / 5 to be taken up by one.
    assert left[0] > 0.05
    assert left[1] < 0.02


@pytest.mark.parametrize(
    ("power", "sizes", "possible"),
    [(3.0, [0.3, 0.2], True), (3.0, [4.0, -4.0], False), (2.0, [0.3, -0.2], False)],
)
def test_two_terms_of_saturation_may_not_undo_one_another(power, sizes, possible) -> None:
    entry, peak = CATALOGUE["torque_saturation"], float(CONTEXT.peak_torque[0])
    reason = entry.plausible(CONTEXT, 0, (power, 2.0), peak * np.array(sizes))
    assert (reason is None) == possible


def test_a_limit_cuts_what_lies_beyond_it() -> None:
    peak = float(np.abs(TOTAL[:, 0]).max())
    cut = np.clip(TOTAL[:, 0], -0.8 * peak, 0.8 * peak) - TOTAL[:, 0]
    column = evaluate(TorqueSaturation(0, CONTEXT.reference, peak, 5.0, "limit"), MOTION, 2)
    assert 0.2 * peak * column[:, 0, 0] == pytest.approx(cut, abs=1e-10)
    assert not column[:, 1].any()


@pytest.mark.parametrize(
    ("lost", "possible"), [(0.2, True), (0.1, True), (0.4, False), (-0.1, False)]
)
def test_a_limit_cuts_no_more_than_lies_beyond_it(lost: float, *, possible: bool) -> None:
    entry, peak = CATALOGUE["torque_saturation"], float(CONTEXT.peak_torque[0])
    reason = entry.plausible(CONTEXT, 0, (5.0, 3.0), np.array([lost * peak]))
    assert (reason is None) is possible


def test_gain_error_scales_the_joints_whole_torque() -> None:
    entry = CATALOGUE["torque_gain"]
    column = evaluate(entry.build(CONTEXT, 1, (1.0,)), MOTION, 2)
    assert column[:, 1, 0] == pytest.approx(TOTAL[:, 1], abs=1e-10)
    assert not column[:, 0].any()
    exact = entry.apply(CONTEXT, 1, (1.0,), np.array([0.1])).torque(CONTEXT.parameters, MOTION)
    assert exact[:, 1] == pytest.approx(1.1 * TOTAL[:, 1], abs=1e-10)
    assert exact[:, 0] == pytest.approx(TOTAL[:, 0], abs=1e-10)


def test_an_amplifier_of_two_halves_has_a_gain_for_each_sign() -> None:
    entry, sizes = CATALOGUE["torque_gain"], np.array([0.1, -0.04])
    columns = evaluate(entry.build(CONTEXT, 1, (2.0,)), MOTION, 2)
    expected = np.where(TOTAL[:, 1] > 0, 0.06, 0.14) * TOTAL[:, 1]
    assert columns[:, 1] @ sizes == pytest.approx(expected, abs=1e-10)
    exact = entry.apply(CONTEXT, 1, (2.0,), sizes).torque(CONTEXT.parameters, MOTION)
    assert exact[:, 1] == pytest.approx(TOTAL[:, 1] + expected, abs=1e-10)
    assert exact[:, 0] == pytest.approx(TOTAL[:, 0], abs=1e-10)


def test_a_further_step_of_the_same_gain_adds_to_it():
    arm = vertical_arm()
    context = context_of(arm, smooth_motion(arm))
    entry = CATALOGUE["torque_gain"]
    for sizes in ((0.1, 0.02), (-0.03, 0.01)):
        model = entry.apply(context, 0, (2.0,), np.array(sizes))
        context = dataclasses.replace(context, model=model)
    (gain,) = context.model.measurement
    assert (gain.gain, gain.by_sign) == pytest.approx((1.07, 0.03))
    other = entry.apply(context, 1, (1.0,), np.array([0.1]))
    assert [g.joint for g in other.measurement] == [0, 1]
