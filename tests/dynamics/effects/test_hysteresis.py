"""Presliding friction against closed forms and against Dahl's own equation."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.hysteresis import PreslidingHysteresis, maxwell_elements
from tests.dynamics.effects.arms import context_of, scara, smooth_motion

DISTANCE = 0.02  # [rad]


def test_single_element_loop_has_the_area_of_its_parallelogram() -> None:
    amplitude = 0.1
    q = amplitude * np.sin(np.linspace(0, 6 * np.pi, 60_001))
    z = maxwell_elements(q, np.array([DISTANCE]))[:, 0]
    last = slice(40_000, 60_001)
    area = np.trapezoid(z[last], q[last])
    assert area == pytest.approx(4 * (amplitude - DISTANCE), rel=1e-3)


def test_a_swing_within_the_break_away_distance_is_a_spring() -> None:
    q = 0.4 * DISTANCE * np.sin(np.linspace(0, 4 * np.pi, 1001))
    z = maxwell_elements(q, np.array([DISTANCE]))[:, 0]
    assert z == pytest.approx(q / DISTANCE, abs=1e-12)


def test_elements_are_what_one_sample_after_another_makes_of_them() -> None:
    """Also where the joint rests before it turns, or goes on."""
    rng = np.random.default_rng(3)
    q = np.cumsum(rng.integers(-2, 3, 500) * 0.4 * DISTANCE)
    distances = DISTANCE * np.array([0.5, 1.0, 3.0])
    expected = np.zeros((500, 3))
    for k in range(1, 500):
        expected[k] = np.clip(expected[k - 1] + (q[k] - q[k - 1]) / distances, -1, 1)
    assert maxwell_elements(q, distances) == pytest.approx(expected, abs=1e-12)


def test_reversal_curve_at_dahls_roundness_is_dahls() -> None:
    effect = PreslidingHysteresis(0, DISTANCE, roundness=np.sqrt(0.5))
    travel = np.linspace(0, 0.3, 3001)
    q = np.concatenate([travel, 0.3 - travel])
    z = maxwell_elements(q, effect.distances)[3001:].mean(axis=1)
    assert z == pytest.approx(2 * np.exp(-travel / DISTANCE) - 1, abs=0.02)


@pytest.mark.parametrize(("joint", "unexplained"), [(0, 0.02), (1, 1e-3)])
def test_follows_dahls_equation_along_a_smooth_motion(joint: int, unexplained: float) -> None:
    """Joint 1 makes a loop smaller than the break-away distance, where Dahl's does not close."""
    motion = smooth_motion(scara(), duration=10.0, step=2e-3)

    def dahl(t: float, z: np.ndarray) -> np.ndarray:
        v = np.interp(t, motion.t, motion.dq[:, joint])
        return v / DISTANCE * (1 - z * np.sign(v))

    z = solve_ivp(dahl, (0, motion.t[-1]), [0.0], t_eval=motion.t, max_step=4e-3).y[0]
    settled = motion.t > 1.0
    truth = (z - np.sign(motion.dq[:, joint]))[settled]
    effect = PreslidingHysteresis(joint, DISTANCE, roundness=np.sqrt(0.5))
    found = evaluate(effect, motion, 2)[settled, joint, 0]
    assert np.sum((found - truth) ** 2) < unexplained * np.sum(truth**2)


@pytest.mark.parametrize("roundness", [0.0, 0.3, 0.7, 1.0])
def test_elements_share_one_mean_distance(roundness: float) -> None:
    distances = PreslidingHysteresis(0, DISTANCE, roundness).distances
    assert distances.mean() == pytest.approx(DISTANCE)
    assert (distances > 0).all()


def test_column_vanishes_away_from_reversals() -> None:
    motion = smooth_motion(scara(), step=1e-3)
    column = evaluate(PreslidingHysteresis(1, 1e-3, roundness=0.0), motion, 2)[:, 1, 0]
    q, reversal = motion.q[:, 1], np.flatnonzero(np.diff(np.sign(motion.dq[:, 1]))) + 1
    last = np.searchsorted(reversal, np.arange(len(q)), side="right") - 1
    travelled = np.abs(q - q[np.maximum(reversal[last], 0)])
    sliding = (last >= 0) & (travelled > 2.1e-3)
    assert sliding.mean() > 0.5
    assert np.abs(column[sliding]).max() < 1e-12
    assert np.abs(column).max() > 1.0


def test_refuses_a_distance_of_zero() -> None:
    with pytest.raises(ValueError, match="distance"):
        PreslidingHysteresis(0, 0.0)


@pytest.mark.parametrize(("share", "plausible"), [(0.9, True), (1.1, False)])
def test_what_builds_up_may_have_passed_for_viscous_friction(
    share: float, *, plausible: bool
) -> None:
    """Where it builds up over most of the motion, little of it goes with the sign of the speed."""
    context = context_of(scara(), smooth_motion(scara()))
    coulomb, viscous, top = 0.05, 9.8, float(context.top_speed[1])
    parameters = context.parameters.copy()
    names = [p.name for p in context.model.parameters]
    parameters[names.index("Fc_2")], parameters[names.index("Fv_2")] = coulomb, viscous
    context = dataclasses.replace(context, parameters=parameters)
    built_up = share * (coulomb + viscous * top)
    assert built_up > 6 * coulomb
    reason = CATALOGUE["presliding_hysteresis"].plausible(
        context, 1, (DISTANCE, 0.7), np.array([built_up])
    )
    assert (reason is None) is plausible
