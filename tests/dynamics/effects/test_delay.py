"""Late torque: a delay shifts, a lag has the gain and phase of its transfer function."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.delay import FilterLag, TimeDelay, delayed
from oed.dynamics.effects.friction import Coulomb
from oed.dynamics.effects.linear_filter import respond
from oed.dynamics.effects.motor import RotorInertia
from oed.dynamics.effects.torque_change import TorqueChange
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.band import Band
from oed.robot import Robot, imi_scara
from tests.dynamics.effects.arms import context_of, smooth_motion, vertical_arm


def _sinusoid(t: np.ndarray, w: float) -> Motion:
    q = np.stack([np.sin(w * t), 0.5 * np.cos(w * t)], axis=1)
    dq = w * np.stack([np.cos(w * t), -0.5 * np.sin(w * t)], axis=1)
    return Motion(t, q, dq, -(w**2) * q)


def _phasor(t: np.ndarray, y: np.ndarray, w: float) -> complex:
    basis = np.stack([np.cos(w * t), np.sin(w * t)], axis=1)
    cosine, sine = np.linalg.lstsq(basis, y, rcond=None)[0]
    return complex(cosine, -sine)


def test_delay_on_a_sinusoid_is_the_shifted_model() -> None:
    model = TorqueModel.standard(imi_scara())
    t, w, delay = np.arange(0, 4, 1e-3), 5.0, 0.0123
    late = model.with_measurement(TimeDelay(delay)).columns(_sinusoid(t, w))
    exact = model.columns(_sinusoid(t - delay, w))
    inside = t > delay
    friction = [20, 22]  # Coulomb columns jump: compared apart
    smooth = [c for c in range(len(model.parameters)) if c not in friction]
    assert late[inside][:, :, smooth] == pytest.approx(exact[inside][:, :, smooth], abs=1e-7)
    different = late[inside][:, :, friction] != exact[inside][:, :, friction]
    assert different.sum() == 0


def test_delay_of_nothing_changes_nothing() -> None:
    motion = smooth_motion(imi_scara())
    same = delayed(motion, 0.0)
    for field in ("q", "dq", "ddq"):
        assert getattr(same, field) == pytest.approx(getattr(motion, field), abs=1e-12)


def test_before_the_first_sample_the_arm_stands_in_its_first_state() -> None:
    motion = smooth_motion(imi_scara())
    late = delayed(motion, 0.05)
    assert late.q[:25] == pytest.approx(np.tile(motion.q[0], (25, 1)), abs=1e-9)


@pytest.mark.parametrize("curvature", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("w", [3.0, 40.0])
def test_lag_has_the_gain_and_phase_of_its_transfer_function(curvature: float, w: float) -> None:
    model = TorqueModel(imi_scara(), (RotorInertia(0),))
    t, T = np.arange(0, 6, 1e-3), 0.02
    motion = _sinusoid(t, w)
    seen = model.with_measurement(FilterLag(T, curvature)).columns(motion)[:, 0, 0]
    settled = t > 1.0
    ratio = _phasor(t[settled], seen[settled], w) / _phasor(t, motion.ddq[:, 0], w)
    s = 1j * w
    expected = 1 / (1 + T * s + curvature * (T * s) ** 2)
    assert abs(ratio - expected) < 1e-3 * abs(expected)


def test_all_orders_share_one_delay_at_low_frequency() -> None:
    w, T = 2.0, 0.01
    phases = [np.angle(1 / (1 + T * 1j * w - k * (T * w) ** 2)) for k in (0.0, 0.25, 0.5)]
    assert np.ptp(phases) < 1e-3 * abs(phases[0])


def test_lag_keeps_a_constant_and_a_standing_start() -> None:
    t = np.arange(0, 1, 1e-3)
    u = np.full((len(t), 2, 1), 3.0)
    assert respond(t, u, [1.0], [1e-4, 0.02, 1.0]) == pytest.approx(u, abs=1e-9)


@pytest.mark.parametrize("curvature", [1e-16, 1e-10, 1e-5])
def test_a_pole_faster_than_any_sample_shows_is_none(curvature: float) -> None:
    t, T = np.arange(0, 1, 0.01), 3e-3
    u = np.sin(9 * t)[:, None, None]
    plain, bent = (respond(t, u, [1.0], [*c, T, 1.0]) for c in ([], [curvature * T**2]))
    assert bent == pytest.approx(plain, abs=1e-4)


def test_uneven_samples_are_filtered_like_even_ones() -> None:
    rng = np.random.default_rng(3)
    even = np.arange(0, 2, 1e-3)
    uneven = even + np.concatenate([[0], rng.uniform(-2e-4, 2e-4, len(even) - 2), [0]])
    answers = [respond(t, np.sin(9 * t)[:, None, None], [1.0], [0.02, 1.0]) for t in (even, uneven)]
    assert answers[1][:, 0, 0] == pytest.approx(
        np.interp(uneven, even, answers[0][:, 0, 0]), abs=2e-4
    )


def test_refuses_a_lag_that_runs_ahead() -> None:
    with pytest.raises(ValueError, match="time_constant"):
        FilterLag(-0.01)


@pytest.mark.parametrize("measurement", [TimeDelay(4e-3), FilterLag(4e-3)])
def test_the_change_with_coefficient_one_is_the_exact_effect(measurement) -> None:
    arm: Robot = vertical_arm()
    motion = smooth_motion(arm)
    context = context_of(arm, motion)
    model = context.model.with_effects(TorqueChange(measurement, context.reference))
    exact = context.model.with_measurement(measurement).torque(context.parameters, motion)
    linear = model.torque(np.append(context.parameters, 1.0), motion)
    assert linear == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("rate", [100.0, 200.0, 500.0])
@pytest.mark.parametrize("delay", [3e-4, 1.7e-3, -9.3e-3])
def test_means_over_a_step_are_moved_by_less_than_it(rate, delay) -> None:
    """Friction's reversals as they lie on a grid of 20 kHz, in the band of a diagnosis."""
    arm, dense = vertical_arm(), round(20e3 / rate)

    def seen(every: int) -> np.ndarray:
        band = Band(rate=rate * every, factor=every, cutoff=8.0, smoothing=24.0)
        motion = dataclasses.replace(smooth_motion(arm, step=1 / band.rate), averaged=True)
        model, parameters = context.model, context.parameters
        late = model.with_measurement(TimeDelay(delay)).torque(parameters, motion)
        change = late - model.torque(parameters, motion)
        start = round(0.6 * band.rate) - band.reach  # the first row lies at this instant
        return band.apply(change[start:])

    context = context_of(arm)
    true, found = seen(dense), seen(1)
    rows = min(len(true), len(found))
    error = np.std(found[:rows] - true[:rows], axis=0)
    # The cubic between samples misses what is nearest to their Nyquist frequency: most at 100 Hz.
    assert np.all(error < 0.01 * np.std(true, axis=0))


@pytest.mark.parametrize("averaged", [False, True])
def test_a_delay_among_candidates_is_the_delay_of_a_model(averaged) -> None:
    arm = vertical_arm()
    motion = dataclasses.replace(smooth_motion(arm), averaged=averaged)
    context = context_of(arm, motion)
    late = context.model.with_measurement(TimeDelay(3.3e-3))
    change = context.model.with_effects(TorqueChange(TimeDelay(3.3e-3), context.reference))
    one = change.torque(np.append(context.parameters, 1.0), motion)
    assert one == pytest.approx(late.torque(context.parameters, motion), abs=1e-9)


def test_a_small_delay_is_minus_the_derivative() -> None:
    arm = vertical_arm()
    motion = smooth_motion(arm, step=1e-3)
    context = context_of(arm, motion)
    smooth = dataclasses.replace(context.reference, others=(), coefficients=())
    change = TorqueChange(TimeDelay(1e-3), smooth)
    column = TorqueModel(arm, (change,)).columns(motion)[5:-5, :, 0]
    slope = np.gradient(smooth.parts(motion).sum(axis=2), motion.t, axis=0)[5:-5]
    assert np.abs(column + 1e-3 * slope).max() < 5e-3 * np.abs(column).max()


def test_a_delayed_sign_stays_sharp() -> None:
    model = TorqueModel(imi_scara(), (Coulomb(0),))
    motion = _sinusoid(np.arange(0, 4, 1e-3), 5.0)
    late = model.with_measurement(TimeDelay(0.0105)).columns(motion)[:, 0, 0]
    assert set(np.unique(late)) <= {-1.0, 0.0, 1.0}
