import dataclasses

import numpy as np
import pytest

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.energy_model import EnergyModel
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.control import Controller
from oed.experiment.disturbance import Disturbance
from oed.experiment.imi_laboratory import ImiLaboratory
from oed.experiment.observer import HighGainObserver
from oed.experiment.paper_signals import processed_signals, sample_runs, zero_phase_cutoff
from oed.experiment.signals.lowpass import half_power_frequency
from oed.experiment.signals.online_filter import PAPER_FILTER
from oed.experiment.simulation import Log, run
from oed.robot.builtin import imi_scara

PERIOD = 1e-3
# The gains that the laboratory designs, rounded: designing them anew takes a second.
GAINS = Controller((4170.0, 178.0), (109.0, 3.1), HighGainObserver.paper())


def reference(seconds: float = 5.0) -> Motion:
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    a, w = np.array([[0.8, 0.5], [0.5, -0.4]]), np.array([[1.7, 1.3], [0.9, 1.8]])
    phase = t[:, None, None] * w
    q, dq, ddq = (
        (a * f).sum(axis=1) for f in (np.sin(phase), w * np.cos(phase), -(w**2) * np.sin(phase))
    )
    return Motion(t, q, dq, ddq)


@pytest.fixture(scope="module")
def quiet_log() -> Log:
    """Plain friction, no disturbance, exact position reading."""
    laboratory = ImiLaboratory(resolver_bits=40)
    setup = laboratory.setup("plain", GAINS, Disturbance.none(2))
    return run(setup, reference(), np.random.default_rng(0), runs=1)


def planar_order(base: BaseParameters) -> list[int]:
    names = ("Izz_1", "mx_2", "my_2", "Izz_2", "Fc_1", "Fv_1", "Fc_2", "Fv_2")
    return [base.names.index(name) for name in names]


def test_truth_is_the_paper_s_estimate():
    truth = ImiLaboratory().truth()
    np.testing.assert_allclose(
        truth, [3.923, 0.808, 0.328, 0.141, 2.61, 7.343, 1.460, 0.787], rtol=1e-12
    )


def test_both_sides_filtered_alike_find_the_truth_while_the_joints_move(quiet_log):
    # Around a reversal the joint sticks, which sgn(dq) cannot say: those samples are left out.
    runs = sample_runs(quiet_log, PERIOD, 400, "parallel")
    at = quiet_log.lead + np.round(np.arange(400) * quiet_log.samples / 400).astype(int)
    slow = np.abs(quiet_log.dq[:, :, 0]).min(axis=1) < 0.1
    memory = 400  # [samples]: eight of the slower time constants of the filter, 0.05 s
    clear = np.array([not slow[k - memory : k + 1].any() for k in at])
    assert clear.sum() > 60
    columns, tau = runs.columns[0, clear], runs.tau[0, clear]
    residual = tau - columns @ ImiLaboratory().truth()
    assert np.abs(residual).max() < 0.02


def test_the_online_filter_biases_the_estimate_more_than_parallel_filtering(quiet_log):
    truth = ImiLaboratory().truth()

    def error(processing):
        runs = sample_runs(quiet_log, PERIOD, 400, processing)
        found = np.linalg.lstsq(runs.regressor, runs.tau.ravel(), rcond=None)[0]
        return np.sqrt((((found - truth) / truth) ** 2).mean())

    assert error("online") > 1.5 * error("parallel")


def test_energy_and_torque_estimates_agree_without_noise(quiet_log):
    model = TorqueModel.standard(imi_scara())
    base = base_parameters(model)
    order = planar_order(base)
    proper = slice(quiet_log.lead, quiet_log.lead + quiet_log.samples)
    q, dq = (x[proper, :, 0] for x in (quiet_log.q, quiet_log.dq))
    motion = Motion(reference().t, q, dq, np.gradient(dq, PERIOD, axis=0))
    form = EnergyModel(model, 25)
    rows = base.reduce(form.regressor(motion))[:, order]
    work = form.target(motion, quiet_log.command[proper, :, 0])
    energy = np.linalg.lstsq(rows, work, rcond=None)[0]
    np.testing.assert_allclose(energy, ImiLaboratory().truth(), rtol=0.06, atol=0.03)


def test_zero_phase_filter_has_the_half_power_of_the_paper_s():
    wanted = PAPER_FILTER.half_power_frequency() / (2 * np.pi)
    assert half_power_frequency(zero_phase_cutoff()) == pytest.approx(wanted)


def test_spectral_derivatives_are_exact_for_a_periodic_motion():
    samples, harmonics = 2000, 2
    t = np.arange(samples) * PERIOD
    w = 2 * np.pi / (samples * PERIOD)
    q = np.stack([0.3 * np.sin(w * t), 0.2 * np.cos(2 * w * t)], axis=1)[:, :, None]
    zero = np.zeros_like(q)
    log = Log(t[:, None], zero, zero, q, zero, zero, lead=0, samples=samples)
    _, dq, ddq, _ = processed_signals(log, PERIOD, "spectral", harmonics=harmonics)
    np.testing.assert_allclose(dq[:, 0, 0], 0.3 * w * np.cos(w * t), atol=1e-9)
    np.testing.assert_allclose(ddq[:, 1, 0], -0.2 * (2 * w) ** 2 * np.cos(2 * w * t), atol=1e-9)


def test_parallel_processing_gives_no_signals(quiet_log):
    with pytest.raises(ValueError, match="regressor"):
        processed_signals(quiet_log, PERIOD, "parallel")


def test_a_choice_of_the_laboratory_reaches_the_arm():
    base = ImiLaboratory(resolver_bits=40)
    smooth = dataclasses.replace(base, ripple=0.0)
    logs = [
        run(
            lab.setup("rich", GAINS, Disturbance.none(2)),
            reference(1.0),
            np.random.default_rng(0),
            runs=1,
        )
        for lab in (base, smooth)
    ]
    moving = slice(logs[0].lead, logs[0].lead + 400)
    difference = (logs[0].command - logs[1].command)[moving, 0, 0]
    expected = 0.1 * 2.61 * np.sin(8 * logs[0].q[moving, 0, 0])
    assert np.abs(difference - expected).max() < 0.08


def test_rich_friction_leaves_more_than_the_paper_s_model_explains():
    laboratory = ImiLaboratory(resolver_bits=40)

    def left(friction):
        setup = laboratory.setup(friction, GAINS, Disturbance.none(2))
        log = run(setup, reference(), np.random.default_rng(0), runs=1)
        runs = sample_runs(log, PERIOD, 200, "parallel")
        found = np.linalg.lstsq(runs.regressor, runs.tau.ravel(), rcond=None)[0]
        return np.sqrt(((runs.tau - runs.columns @ found) ** 2).mean(axis=(0, 1)))

    assert (left("rich") > 2 * left("plain")).all()
