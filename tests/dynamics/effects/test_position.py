"""Ripple, uneven friction, springs; and trial values fine enough to find them."""

import dataclasses

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.catalogue import CATALOGUE, Context, Drives
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.motor import CrossCoupling
from oed.dynamics.effects.position import JointSpring, PositionFriction, TorqueRipple
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import context_of, parameters_of, scara, smooth_motion

MOTION = smooth_motion(scara())
Q, V = MOTION.q[:, 1], MOTION.dq[:, 1]


def test_ripple_does_not_know_the_direction() -> None:
    columns = evaluate(TorqueRipple(1, (4.0, 9.5)), MOTION, 2)[:, 1]
    expected = np.stack([np.cos(4 * Q), np.sin(4 * Q), np.cos(9.5 * Q), np.sin(9.5 * Q)], axis=1)
    assert columns == pytest.approx(expected, abs=1e-12)


def test_uneven_friction_turns_with_the_direction() -> None:
    columns = evaluate(PositionFriction(1, (2.0,)), MOTION, 2)[:, 1]
    expected = np.stack([np.cos(2 * Q), np.sin(2 * Q)], axis=1) * np.sign(V)[:, None]
    assert columns == pytest.approx(expected, abs=1e-12)


def test_spring_columns_make_any_rest_position() -> None:
    stiffness, rest, centre = 3.0, 0.4, 0.1
    columns = evaluate(JointSpring(1, centre), MOTION, 2)[:, 1]
    torque = columns @ np.array([stiffness, stiffness * (centre - rest)])
    assert torque == pytest.approx(stiffness * (Q - rest))


def test_spring_leaves_the_constant_to_an_offset_that_is_there() -> None:
    model = TorqueModel.standard(scara(), offset=True)
    parameters = np.concatenate([model.robot.parameters, np.ones(6)])
    context = Context.of(model, parameters, [MOTION])
    assert len(CATALOGUE["joint_spring"].build(context, 0, (1.0,)).parameters) == 1
    without = context_of(scara(), MOTION)
    assert len(CATALOGUE["joint_spring"].build(without, 0, (1.0,)).parameters) == 2


def test_a_spring_that_tightens_is_a_polynomial_with_a_positive_slope() -> None:
    linear, cubic, rest, centre = 2.0, 0.7, 0.2, 0.1
    columns = evaluate(JointSpring(1, centre, order=3), MOTION, 2)[:, 1]
    pull = np.polynomial.Polynomial([-rest, 1.0])  # stretch by position
    whole = (linear * pull + cubic * pull**3)(np.polynomial.Polynomial([centre, 1.0]))
    constant, *powers = whole.coef
    assert columns @ np.array([*powers, constant]) == pytest.approx(
        linear * (Q - rest) + cubic * (Q - rest) ** 3
    )


@pytest.mark.parametrize(("quadratic", "plausible"), [(0.5, True), (40.0, False)])
def test_a_spring_pulls_back_harder_everywhere_it_was_stretched(
    quadratic: float, *, plausible: bool
) -> None:
    context = context_of(scara(), MOTION)
    estimates = np.array([2.0, quadratic, 0.0, 0.1])
    reason = CATALOGUE["joint_spring"].plausible(context, 1, (2.0,), estimates)
    assert (reason is None) == plausible


@pytest.mark.parametrize(
    ("share", "half", "is_ripple"), [(2.1, 5.0, True), (1.9, 0.5, True), (1.9, 2.0, False)]
)
def test_half_a_ripples_wave_is_no_longer_than_a_ripple_may_be_or_little(
    share: float, half: float, *, is_ripple: bool
) -> None:
    context, ripple = context_of(scara(), MOTION), CATALOGUE["torque_ripple"]
    shape, _ = ripple.shapes_for(context, 1)
    values = (share * shape.lower, 4.0)  # with half its harmonic
    waves = dict(zip(ripple.build(context, 1, values).harmonics, (1.0, 0.3, half), strict=True))
    reason = ripple.plausible(context, 1, values, 1e-3 * np.repeat(list(waves.values()), 2))
    assert (reason is None) is is_ripple


def left_by_spring(torque: Float[ndarray, " samples"], formula: float) -> float:
    """Squares that the best spring of a formula leaves of a torque; none of it has to push."""
    context, spring = context_of(scara(), MOTION), CATALOGUE["joint_spring"]
    columns = evaluate(spring.build(context, 1, (formula,)), MOTION, 2)[:, 1]
    estimates = np.linalg.lstsq(columns, torque, rcond=None)[0]
    assert spring.plausible(context, 1, (formula,), estimates) is None
    return float(np.sum((torque - columns @ estimates) ** 2))


@pytest.mark.parametrize("end", [-0.7, -0.25, 0.0, 0.4])
def test_a_cable_that_goes_slack_is_a_spring_in_stretches(end: float) -> None:
    """To a tenth of what a line misses, wherever it goes slack, and none of it has to push."""
    context = context_of(scara(), MOTION)
    least, largest = context.position_range[1]
    slack = (least + largest) / 2 + end * (largest - least) / 2
    torque = 1.3 * np.maximum(Q - slack, 0.0)
    assert left_by_spring(torque, 3.0) < 0.1 * left_by_spring(torque, 1.0)


def test_a_cable_that_is_slack_in_the_middle_is_a_spring_in_finer_stretches() -> None:
    """To a fiftieth of what a line misses, where coarse stretches leave a tenth and more."""
    context = context_of(scara(), MOTION)
    least, largest = context.position_range[1]
    offset = Q - (least + largest) / 2 - 0.05 * (largest - least)
    torque = 1.3 * np.sign(offset) * np.maximum(np.abs(offset) - 0.06 * (largest - least), 0.0)
    line, coarse, fine = (left_by_spring(torque, formula) for formula in (1.0, 3.0, 4.0))
    assert fine < 0.02 * line
    assert coarse > 0.1 * line


def test_a_spring_in_stretches_does_not_push() -> None:
    context = context_of(scara(), MOTION)
    estimates = np.array([2.0, 0.0, -4.0, 4.0, 0.0, 0.1])
    assert CATALOGUE["joint_spring"].plausible(context, 1, (3.0,), estimates) is not None


def test_a_wave_may_have_its_overtone() -> None:
    context = context_of(scara(), MOTION)
    for name in ("torque_ripple", "position_dependent_friction"):
        plain, fuller = (CATALOGUE[name].build(context, 1, (4.0, k)) for k in (1.0, 2.0))
        own, both = (evaluate(effect, MOTION, 2)[:, 1] for effect in (plain, fuller))
        assert fuller.harmonics == (4.0, 8.0)
        assert both[:, :2] == pytest.approx(own)


@pytest.mark.parametrize(("share", "is_plausible"), [(1.5, True), (2.5, False)])
def test_a_balancer_may_carry_more_than_the_drive_shows(share: float, is_plausible: bool) -> None:
    context = context_of(scara(), MOTION)
    swing = float(np.ptp(context.position_range[1])) / 2
    stiffness = share * float(context.peak_torque[1]) / swing
    reason = CATALOGUE["joint_spring"].plausible(context, 1, (1.0,), np.array([stiffness, 0.0]))
    assert (reason is None) is is_plausible


@pytest.mark.parametrize("harmonic", [14.2, 17.7, 61.2, 129.0, 320.0])
def test_first_scan_comes_near_enough_to_every_ripple(harmonic: float) -> None:
    context = context_of(scara(), MOTION)
    shape, _ = CATALOGUE["torque_ripple"].shapes_for(context, 1)
    truth = np.cos(harmonic * Q + 0.3)
    nearest = min(shape.grid, key=lambda n: abs(n - harmonic))
    columns = evaluate(TorqueRipple(1, (nearest,)), MOTION, 2)[:, 1]
    fitted = columns @ np.linalg.lstsq(columns, truth, rcond=None)[0]
    assert np.sum(fitted**2) > 0.5 * np.sum(truth**2)


def test_a_known_gear_ratio_widens_the_search_to_the_motors_harmonics() -> None:
    model = TorqueModel.standard(scara())
    context = Context.of(model, parameters_of(model), [MOTION], Drives(gear_ratio=(100.0, 80.0)))
    shape, _ = CATALOGUE["torque_ripple"].shapes_for(context, 0)
    assert shape.upper == pytest.approx(420.0)


@pytest.mark.parametrize("name", ["torque_ripple", "position_dependent_friction"])
def test_teeth_of_a_slide_are_counted_on_its_pinion(name: str) -> None:
    robot = scara()
    slide = dataclasses.replace(robot.joints[1], kind="prismatic")
    rack = dataclasses.replace(robot, joints=(robot.joints[0], slide))
    turning, sliding = (
        CATALOGUE[name].shapes_for(context_of(r, MOTION), 1)[0] for r in (robot, rack)
    )
    assert sliding.upper * slide.speed(1.0) == pytest.approx(turning.upper)


def test_a_wave_longer_than_half_the_motion_is_no_ripple() -> None:
    context = context_of(scara(), MOTION)
    shape, _ = CATALOGUE["torque_ripple"].shapes_for(context, 1)
    assert shape.lower * np.ptp(Q) == pytest.approx(4 * np.pi)


def test_coupling_is_the_other_joints_motion_and_its_inertia_is_mutual() -> None:
    columns = evaluate(CrossCoupling(0, 1), MOTION, 2)
    expected = np.stack([MOTION.ddq[:, 1], V, np.sign(V)], axis=1)
    assert columns[:, 0] == pytest.approx(expected)
    assert columns[:, 1, 0] == pytest.approx(MOTION.ddq[:, 0])
    assert not columns[:, 1, 1:].any()
    one_row = evaluate(CrossCoupling(0, 1, mutual=False), MOTION, 2)
    assert one_row[:, 0] == pytest.approx(columns[:, 0])
    assert not one_row[:, 1].any()
    with pytest.raises(ValueError, match="itself"):
        CrossCoupling(1, 1)


@pytest.mark.parametrize(("share", "plausible"), [(1.3, True), (1.7, False)])
def test_part_of_a_wave_may_exceed_the_friction_that_is_known_without_it(
    share: float, *, plausible: bool
) -> None:
    """Its mean where the arm goes has passed for Coulomb friction; a ripple has no such excuse."""
    context = context_of(scara(), MOTION)
    size = np.array([share * context.coulomb(1), 0.0])
    fault = CATALOGUE["position_dependent_friction"].plausible(context, 1, (1.0, 1.0), size)
    assert (fault is None) is plausible
    assert CATALOGUE["torque_ripple"].plausible(context, 1, (20.0, 1.0), size) is not None
