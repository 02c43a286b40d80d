"""Friction as a function of speed alone, against formulas written independently."""

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.nonlinear_viscous import AsymmetricViscous, NonlinearViscous
from oed.dynamics.effects.stribeck import Stribeck
from tests.dynamics.effects.arms import context_of, scara, smooth_motion

MOTION = smooth_motion(scara())
V = MOTION.dq[:, 1]


def _column(effect) -> np.ndarray:
    columns = evaluate(effect, MOTION, 2)
    assert not columns[:, 0].any()
    return columns[:, 1, 0]


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_stribeck_without_tail_is_exponential(exponent: float) -> None:
    expected = np.exp(-((np.abs(V) / 0.1) ** exponent)) * np.sign(V)
    assert _column(Stribeck(1, 0.1, exponent)) == pytest.approx(expected, abs=1e-14)


def test_stribeck_with_full_tail_is_hess_and_soom() -> None:
    expected = np.sign(V) / (1 + (V / 0.1) ** 2)
    assert _column(Stribeck(1, 0.1, 2.0, tail=1.0)) == pytest.approx(expected, abs=1e-14)


def test_stribeck_tail_joins_the_two_without_a_jump() -> None:
    exponential = _column(Stribeck(1, 0.1, 2.0))
    assert _column(Stribeck(1, 0.1, 2.0, tail=1e-6)) == pytest.approx(exponential, abs=1e-6)
    between = np.abs(_column(Stribeck(1, 0.1, 2.0, tail=0.5)))
    algebraic = np.abs(_column(Stribeck(1, 0.1, 2.0, tail=1.0)))
    assert (np.abs(exponential) <= between + 1e-12).all()
    assert (between <= algebraic + 1e-12).all()


def test_a_width_turns_the_sign_smoothly() -> None:
    expected = np.exp(-((V / 0.1) ** 2)) * np.tanh(V / 0.02)
    assert _column(Stribeck(1, 0.1, width=0.02)) == pytest.approx(expected, abs=1e-14)


def test_power_of_speed_is_odd() -> None:
    expected = np.abs(V) ** 0.4 * np.sign(V)
    assert _column(NonlinearViscous(1, 0.4)) == pytest.approx(expected, abs=1e-14)


def test_shear_thinning_levels_off() -> None:
    expected = V / (1 + np.abs(V) / 0.5)
    assert _column(NonlinearViscous(1, 1.0, thinning=2.0)) == pytest.approx(expected, abs=1e-14)


def test_asymmetric_viscous_is_even() -> None:
    assert _column(AsymmetricViscous(1)) == pytest.approx(np.abs(V))


@pytest.mark.parametrize(
    ("kind", "arguments"),
    [(Stribeck, (0, 0.0)), (Stribeck, (0, 0.1, 2.0, 1.5)), (NonlinearViscous, (0, 0.0))],
)
def test_refuses_shapes_without_meaning(kind: type, arguments: tuple) -> None:
    with pytest.raises(ValueError, match="must be positive"):
        kind(*arguments)


@pytest.mark.parametrize(
    ("size", "exponent", "falls"), [(-1.0, 0.6, True), (1.0, 0.6, False), (-0.1, 2.0, False)]
)
def test_friction_that_falls_as_a_joint_sets_off_is_stribecks(
    size: float, exponent: float, *, falls: bool
) -> None:
    context = context_of(scara(), MOTION)
    shapes, estimates = (exponent, 0.0), np.array([size])
    reason = CATALOGUE["nonlinear_viscous"].plausible(context, 1, shapes, estimates)
    assert (reason is not None and "Stribeck" in reason) is falls


@pytest.mark.parametrize(("share", "falls"), [(0.9, False), (1.1, True)])
def test_friction_that_rises_at_low_speed_alone_is_a_sign_that_turns_slowly(
    share: float, *, falls: bool
) -> None:
    context = context_of(scara(), MOTION)
    exponent, top = 0.5, float(context.top_speed[1])
    speed = np.linspace(0.01, top, 400)
    shapes = (exponent, share * exponent / (1 - exponent) / top)
    law = speed ** shapes[0] / (1 + shapes[1] * speed)
    assert bool(np.diff(law)[-1] < 0) is falls
    reason = CATALOGUE["nonlinear_viscous"].plausible(context, 1, shapes, np.array([0.5]))
    assert (reason is not None) is falls
