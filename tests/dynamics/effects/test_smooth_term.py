"""smooth terms: what a loop can follow that no function of the present state can."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from oed.dynamics.effects import State
from oed.dynamics.effects.arguments import Factor, Loop, VaryingInertia
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.dynamics.motion import Motion
from oed.estimation.noise_floor.linear_fit import effect_columns

RATE = 500.0


@pytest.fixture(scope="module")
def motion():
    t = np.arange(0, 20, 1 / RATE)
    phases = np.array([0.0, 1.0]), np.array([2.0, 0.5])
    q = np.sum(
        [
            np.sin(2 * np.pi * f * t[:, None] + phase) / (1 + k)
            for k, (f, phase) in enumerate(zip((0.15, 0.4), phases, strict=True))
        ],
        axis=0,
    )
    dq = np.gradient(q, t, axis=0)
    return Motion(t, q, dq, np.gradient(dq, t, axis=0))


def _hose(motion, reach):
    """Dahl's equation on the first joint: h' = (v - |v| h) / reach, integrated step by step."""
    h = np.zeros(len(motion))
    for k in range(1, len(h)):
        step = motion.q[k, 0] - motion.q[k - 1, 0]
        target = np.sign(step)
        h[k] = target + (h[k - 1] - target) * np.exp(-abs(step) / reach)
    return h


def _left(term, motion, torque):
    """Share of a torque that a term cannot follow."""
    columns = effect_columns(term, motion, 0.0)[1]
    found = np.linalg.lstsq(columns, torque, rcond=None)[0]
    return float(np.std(torque - columns @ found) / np.std(torque))


@pytest.mark.parametrize("direction", [None, 1])
def test_a_torque_is_the_sum_of_its_columns(motion, direction):
    rng = np.random.default_rng(5)
    pair = (Coordinate("q", 0, -0.5, 0.5, 4), Coordinate("dq", 1, -1.0, 1.0, 6))
    for term in (
        SmoothTerm(1, pair[:1], direction=direction),
        SmoothTerm(1, pair, direction=direction),
    ):
        sizes = rng.normal(size=len(term.parameters))
        (joint, torque), *more = term.torque(State.along(motion), sizes).items()
        assert joint == 1
        assert not more
        assert torque == pytest.approx(effect_columns(term, motion, 0.0)[1] @ sizes, abs=1e-12)


@pytest.mark.parametrize("reach", [0.05, 0.2])
def test_a_loop_of_another_joint_follows_what_that_joint_drags(motion, reach):
    torque = _hose(motion, reach)
    loop = SmoothTerm(1, (Loop(0, 0.01, 1.0, 6),))
    assert _left(loop, motion, torque) < 0.12
    for kind in ("q", "dq"):
        lower, upper = (float(f(getattr(motion, kind)[:, 0])) for f in (np.min, np.max))
        present = SmoothTerm(1, (Coordinate(kind, 0, lower, upper, 8),))
        assert _left(present, motion, torque) > 0.3


def test_a_loop_says_what_it_depends_on():
    term = SmoothTerm(1, (Loop(0, 0.01, 1.0, 6),))
    assert term.depends_on == ("q_1", "dq_1")
    assert term.label == "f(loop of q_1)"
    assert len(term.parameters) == 6
    assert len({p.name for p in term.parameters}) == 6
    assert term.remembers


def test_a_spline_stays_at_its_edge(motion):
    term = SmoothTerm(1, (Coordinate("q", 0, -0.3, 0.3, 8),))
    columns = effect_columns(term, motion, 0.0)[1]
    assert columns.sum(axis=1) == pytest.approx(1.0)
    beyond = motion.q[:, 0] > 0.3
    assert np.allclose(columns[beyond], columns[beyond][0])


def test_crowded_pieces_are_denser_about_zero():
    even = Coordinate("dq", 0, -2.0, 2.0, 10)
    speeds = np.linspace(-2.0, 2.0, 2001)
    state = State(speeds, [speeds], [speeds], [speeds])
    # The steepest spline tells how narrow the pieces are.
    about_zero = np.abs(speeds[1:]) < 0.3
    ratios = []
    for coordinate in (even, even.crowded()):
        basis = coordinate.basis(state)
        assert basis.sum(axis=1) == pytest.approx(1.0)
        slope = np.abs(np.diff(basis, axis=0)).max(axis=1)
        ratios.append(slope[about_zero].max() / slope[np.abs(speeds[1:] + 1.0) < 0.3].max())
    assert ratios[0] == pytest.approx(1.0, rel=0.1)
    # Slope of asinh(v / 0.2) at zero over that at 0.7, the end of the far window.
    assert ratios[1] == pytest.approx(np.sqrt(1 + (0.7 / 0.2) ** 2), rel=0.1)


@pytest.mark.parametrize("kind", ["dq", "ddq"])
def test_a_function_of_speed_alone_is_no_offset(motion, kind):
    """It vanishes at rest, and is even or odd as it likes."""
    signal = getattr(motion, kind)[:, 0]
    whole = Coordinate(kind, 0, float(signal.min()), float(signal.max()), 8)
    from_rest = SmoothTerm(0, (dataclasses.replace(whole, from_rest=True),))
    still = Motion(np.zeros(1), np.zeros((1, 2)), np.zeros((1, 2)), np.zeros((1, 2)))
    assert effect_columns(from_rest, still, 0.0)[0] == pytest.approx(0.0)
    constant = np.ones(len(motion))
    columns = effect_columns(from_rest, motion, 0.0)[0]
    for torque, follows in ((constant, False), (signal**2, True)):
        found = np.linalg.lstsq(columns, torque, rcond=None)[0]
        left = np.sqrt(np.mean((torque - columns @ found) ** 2) / np.mean(torque**2))
        assert bool(left < 0.01) is follows


def test_a_varying_coefficient_is_linear_in_its_signal(motion):
    term = SmoothTerm(1, (Coordinate("q", 0, -1.0, 1.0, 8), Factor("dq", 1)))
    faster = Motion(motion.t, motion.q, 3.0 * motion.dq, motion.ddq)
    once, thrice = (effect_columns(term, m, 0.0)[1] for m in (motion, faster))
    assert thrice == pytest.approx(3.0 * once)
    assert once.sum(axis=1) == pytest.approx(motion.dq[:, 1])


def test_a_varying_coefficient_says_what_it_is():
    term = SmoothTerm(0, (Coordinate("q", 1, -1.0, 1.0, 8), Factor("dq", 0)))
    assert term.label == "f(q_2) dq_1"
    assert term.depends_on == ("q_2", "dq_1")
    assert len(term.parameters) == 11


def test_a_varying_inertia_keeps_its_energy():
    """Its power is the rate of J dq^2 / 2, whatever J."""
    t = np.arange(0, 10, 1 / RATE)[:, None]
    motion = Motion(t[:, 0], 0.9 * np.sin(2 * t), 1.8 * np.cos(2 * t), -3.6 * np.sin(2 * t))
    term = SmoothTerm(0, (VaryingInertia(Coordinate("q", 0, -1.0, 1.0, 8)),))
    torque = effect_columns(term, motion, 0.0)[0]
    inertia = effect_columns(SmoothTerm(0, (Coordinate("q", 0, -1.0, 1.0, 8),)), motion, 0.0)[0]
    speed = motion.dq[:, :1]
    power = cumulative_trapezoid(torque * speed, motion.t, axis=0, initial=0.0)
    energy = inertia * speed**2 / 2
    # The trapezoidal rule errs by the square of the step, times the power's curvature.
    tolerance = 100 / RATE**2
    assert np.allclose(power, energy - energy[0], atol=tolerance)


def test_a_varying_inertia_says_what_it_is():
    term = SmoothTerm(1, (VaryingInertia(Coordinate("q", 1, -1.0, 1.0, 8)),))
    assert term.label == "f(inertia over q_2)"
    assert term.depends_on == ("q_2", "dq_2", "ddq_2")
