"""The sign of a sampled velocity as a mean over each step, against quadrature."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.delay import delayed
from oed.dynamics.effects.friction import Coulomb
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import mean_sign
from oed.dynamics.torque_model import TorqueModel
from oed.robot import imi_scara

FINE = 4001


def _quadrature(v: np.ndarray, width: float) -> np.ndarray:
    places = np.arange(len(v), dtype=float)
    means = []
    for k in places:
        inside = np.linspace(max(k - 0.5, 0.0), min(k + 0.5, places[-1]), FINE)
        speed = np.interp(inside, places, v)
        means.append(np.trapezoid(np.tanh(speed / width) if width else np.sign(speed), inside))
    length = np.ones(len(v))
    length[[0, -1]] = 0.5
    return np.array(means) / length


@pytest.mark.parametrize("width", [0.0, 0.01, 0.5])
def test_is_the_mean_over_a_step(width: float):
    # Linear between the middles of steps is not linear between samples: only where the velocity
    # is straight over two steps are both the same, so here it is a polygon with wide sides.
    v = np.interp(np.arange(60), [0, 20, 40, 59], [0.9, -0.93, 0.87, 0.05])
    corner = np.isin(np.arange(60), [20, 40])
    found, expected = mean_sign(v, width), _quadrature(v, width)
    # A step of the trapezoidal rule where the sign jumps: 1 / FINE of it.
    assert found[~corner] == pytest.approx(expected[~corner], abs=2 / FINE)


def test_keeps_the_sign_where_nothing_turns():
    assert mean_sign(np.full(5, -2.0), 0.1) == pytest.approx(np.full(5, np.tanh(-20.0)))
    assert mean_sign(np.zeros(4), 0.0) == pytest.approx(np.zeros(4))
    assert mean_sign(np.array([1.0, 1.0 + 1e-15, 3.0]), 0.0) == pytest.approx(np.ones(3))


@pytest.mark.parametrize("delay", [0.0004, 0.001, 0.0031, 0.0072])
def test_friction_moves_by_less_than_a_sample(delay: float):
    # Each reversal from plus to minus that comes later by d adds 2 d to the integral.
    robot = imi_scara()
    t = np.arange(0.0, 1.0, 0.004)
    q = np.stack([np.sin(4 * t), np.zeros_like(t)], axis=1)
    dq = np.stack([4 * np.cos(4 * t), np.ones_like(t)], axis=1)
    motion = Motion(t, q, dq, -16 * q, averaged=True)
    model = TorqueModel(robot, (Coulomb(0),))

    def integral(seen: Motion) -> float:
        # The second reversal, from minus to plus, is left out.
        early = t < 0.8
        return float(model.columns(seen)[early, 0, 0].sum() * 0.004)

    moved = integral(delayed(motion, delay)) - integral(motion)
    # A velocity linear between samples turns within a hundredth of a step of the true one.
    assert moved == pytest.approx(2 * delay, abs=2e-5)
    sharp = dataclasses.replace(motion, averaged=False)
    jumps = (integral(delayed(sharp, delay)) - integral(sharp)) / 0.008
    assert jumps == pytest.approx(round(jumps), abs=1e-9)
