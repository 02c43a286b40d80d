"""Splines: exact where they should be, quiet where they know nothing."""

import casadi
import numpy as np
import pytest
from scipy.interpolate import BSpline

from oed.dynamics.effects.effect import State
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.nonparametric import (
    Coordinate,
    RepetitionTorque,
    Spline,
    SplineTorque,
)
from oed.dynamics.effects.spline import CoordinateKind
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import joint_components
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import context_of, scara, smooth_motion

MOTION = smooth_motion(scara())
STATE = State(MOTION.t, *joint_components(MOTION))


def _spline(kind: CoordinateKind, joint: int, pieces: int = 6) -> Spline:
    coordinate = Coordinate(kind, joint)
    return Spline.covering(coordinate, np.asarray(coordinate.of(STATE)), pieces)


def test_basis_is_that_of_scipy_and_sums_to_one() -> None:
    spline = _spline("q", 0)
    basis = np.stack(spline.basis(STATE), axis=1)
    expected = BSpline.design_matrix(MOTION.q[:, 0], spline.knots, 3).toarray()
    assert basis == pytest.approx(expected, abs=1e-12)
    assert basis.sum(axis=1) == pytest.approx(1.0)


def test_outside_the_coverage_the_end_value_is_held() -> None:
    spline = _spline("q", 0)
    far = State(0.0, [np.array([-9.0, 9.0]), np.zeros(2)], [np.zeros(2)] * 2, [np.zeros(2)] * 2)
    basis = np.stack(spline.basis(far), axis=1)
    ends = np.zeros((2, len(spline)))
    ends[0, 0] = ends[1, -1] = 1.0
    assert basis == pytest.approx(ends, abs=1e-12)
    assert not spline.covered(far).any()
    assert spline.covered(STATE).all()


def test_fits_a_smooth_friction_curve() -> None:
    effect = SplineTorque(1, (_spline("|dq|", 1, 10),), with_direction=True)
    columns = evaluate(effect, MOTION, 2)[:, 1]
    v = MOTION.dq[:, 1]
    truth = (1 + np.exp(-np.abs(v) / 0.3)) * np.sign(v)
    fitted = columns @ np.linalg.lstsq(columns, truth, rcond=None)[0]
    assert np.sqrt(np.mean((fitted - truth) ** 2)) < 0.01
    assert effect.depends_on == ("dq_2",)


def test_a_product_holds_a_function_of_two_coordinates() -> None:
    effect = SplineTorque(0, (_spline("q", 0), _spline("dq", 1))).restricted(STATE)
    columns = evaluate(effect, MOTION, 2)[:, 0]
    truth = np.sin(2 * MOTION.q[:, 0]) * MOTION.dq[:, 1]
    fitted = columns @ np.linalg.lstsq(columns, truth, rcond=1e-8)[0]
    assert np.sqrt(np.mean((fitted - truth) ** 2)) < 0.02 * np.std(truth)
    assert effect.depends_on == ("q_1", "dq_2")


def test_a_product_knows_the_corners_that_no_sample_touched() -> None:
    whole = SplineTorque(0, (_spline("q", 0, 8), _spline("dq", 0, 8)))
    effect = whole.restricted(STATE)
    assert len(effect.parameters) < len(whole.parameters)
    assert effect.covered(STATE).mean() > 0.95
    corner = np.array([MOTION.q[:, 0].max() - 1e-6])
    fast = np.array([MOTION.dq[:, 0].max() - 1e-6])
    state = State(0.0, [corner, corner], [fast, fast], [corner, corner])
    assert not effect.covered(state).any()
    untouched = [float(np.sum(entry[0])) for entry in effect.entries(state)]
    assert sum(untouched) < 0.5


def test_roughness_leaves_a_straight_line_alone() -> None:
    spline = _spline("q", 0)
    basis = np.stack(spline.basis(STATE), axis=1)
    line = np.linalg.lstsq(basis, 3 * MOTION.q[:, 0] - 1, rcond=None)[0]
    assert spline.roughness() @ line == pytest.approx(0.0, abs=1e-8)
    bend = np.linalg.lstsq(basis, MOTION.q[:, 0] ** 2, rcond=None)[0]
    assert np.abs(spline.roughness() @ bend).min() > 1e-3


def test_the_ridge_keeps_coefficients_small() -> None:
    rng = np.random.default_rng(8)
    effect = SplineTorque(0, (_spline("q", 0), _spline("q", 1))).restricted(STATE)
    columns = evaluate(effect, MOTION, 2)[::50, 0]
    noise = rng.normal(size=len(columns))
    penalty = effect.penalty(ridge=1.0, roughness=1.0)
    stacked = np.concatenate([columns, penalty])
    target = np.concatenate([noise, np.zeros(len(penalty))])
    ridged = np.linalg.lstsq(stacked, target, rcond=None)[0]
    free = np.linalg.lstsq(columns, noise, rcond=1e-8)[0]
    assert np.linalg.norm(ridged) < 0.2 * np.linalg.norm(free)


def test_symbols_and_numbers_give_the_same_columns() -> None:
    effect = SplineTorque(0, (_spline("q", 0), _spline("dq", 1)))
    model = TorqueModel(scara(), (effect,))
    q, dq, ddq = (casadi.SX.sym(x, 2) for x in ("q", "dq", "ddq"))
    function = casadi.Function("f", [q, dq, ddq], [model.symbolic_columns(q, dq, ddq, 0.0)])
    for k in range(0, len(MOTION), 500):
        expected = model.columns(MOTION[k : k + 1])[0]
        found = np.asarray(function(MOTION.q[k], MOTION.dq[k], MOTION.ddq[k]))
        assert found == pytest.approx(expected, abs=1e-12)


def test_torque_and_time_are_coordinates_too() -> None:
    reference = context_of(scara(), MOTION).reference
    torque = Coordinate("|tau|", 1, reference)
    expected = np.abs(reference.parts(MOTION).sum(axis=2)[:, 1])
    assert torque.of(STATE) == pytest.approx(expected)
    late = State(MOTION.t + 5.0, STATE.q, STATE.dq, STATE.ddq)
    assert Coordinate("time").of(late) == pytest.approx(MOTION.t)
    with pytest.raises(ValueError, match="reference"):
        Coordinate("tau", 1)


def test_refuses_a_coordinate_that_does_not_vary() -> None:
    with pytest.raises(ValueError, match="does not vary"):
        Spline.covering(Coordinate("q", 0), np.ones(100), 5)


def test_repetitions_have_their_own_torque() -> None:
    effect = RepetitionTorque(1, (4.0, 7.0), kind="Fv")
    columns = evaluate(effect, Motion(MOTION.t + 3, MOTION.q, MOTION.dq, MOTION.ddq), 2)[:, 1]
    second = (MOTION.t >= 4.0) & (MOTION.t < 7.0)
    assert columns[:, 0] == pytest.approx(second * MOTION.dq[:, 1])
    assert columns[:, 1] == pytest.approx((MOTION.t >= 7.0) * MOTION.dq[:, 1])
    assert {p.unit for p in effect.parameters} == {"N m s/rad"}
