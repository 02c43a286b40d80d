"""Friction that follows a measured temperature, each recording beginning at another."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.within import differs_alone
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.entries.history import MEASURED
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import COULOMB, VISCOUS, data_set, once
from tests.diagnosis.shop import shop_of, trial_of

LOST = 0.03  # of friction for each kelvin
MEAN = 30.0  # [degrees Celsius]
SETTINGS = DiagnosisSettings(
    surrogates=39,
    bootstrap=40,
    candidates=("thermal_drift", "payload_change", "nonlinear_viscous", "torque_offset"),
)


def thermometer_of(recording, begin, rise=5.0):
    """What thermometers show of both joints: the first warms up, the second is 21 degrees."""
    rng = np.random.default_rng(round(10 * begin))
    t = recording.t - recording.t[0]
    first = begin + rise * (1 - np.exp(-t / 12.0))
    true = np.stack([first, np.full_like(t, 21.0)], axis=1)
    return true, np.round(true + 0.05 * rng.standard_normal(true.shape), 1)


def warming(begins, *, lost=LOST, rise=5.0, repetitions=1):
    """Recordings of an arm whose first joint has so much friction less for each kelvin."""
    dataset = data_set(5, repetitions=repetitions, roles=ROLES[: len(begins)])
    recordings = []
    for recording, begin in zip(dataset.recordings, begins, strict=True):
        true, shown = thermometer_of(recording, begin, rise)
        speed = np.gradient(recording.q[:, 0], recording.t)
        friction = COULOMB[0] * np.sign(speed) + VISCOUS[0] * speed
        tau = recording.tau.copy()
        tau[:, 0] -= lost * (true[:, 0] - MEAN) * friction
        warmed = dataclasses.replace(recording, tau=tau, temperature=shown)
        recordings.append(warmed if repetitions > 1 else once(warmed))
    return dataclasses.replace(dataset, recordings=tuple(recordings))


ROLES = ("estimation", "validation", "test", "estimation", "estimation", "estimation")


@pytest.mark.parametrize("repetitions", [1, 3])
def test_what_no_clock_explains_a_thermometer_does(repetitions):
    dataset = warming((24.0, 28.0, 33.0, 30.0), repetitions=repetitions)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    (effect,) = found.effects
    assert (effect.name, effect.joint) == ("thermal_drift", 0)
    sizes = {p.name: p for p in effect.parameters}
    for name, friction in (("warming_Fv_1", VISCOUS[0]), ("warming_Fc_1", COULOMB[0])):
        # Three deviations: one draw in 370 lies outside.
        assert abs(sizes[name].value + LOST * friction) < 3 * sizes[name].std
    after = next(p.after for p in found.proof if p.role == "test")
    # The noise floor is known to some percent on 10 s, and the test error is of one draw.
    assert np.all(after < 1.2 * found.noise_floor)


def test_a_thermometer_that_moves_names_nothing_by_itself():
    dataset = warming((24.0, 28.0, 33.0, 30.0), lost=0.0)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    assert found.verdict == "nothing found"


def test_thermometers_that_the_test_recording_lacks_are_none():
    dataset = warming((24.0, 28.0, 33.0))
    *known, test = dataset.recordings
    assert (known[0].role, test.role) == ("estimation", "test")
    bare = dataclasses.replace(test, temperature=None)
    for last, measured in ((test, True), (bare, False)):
        prepared = prepare((*known, last))
        assert all((p.motion.temperature is not None) is measured for p in prepared)


@pytest.mark.parametrize("count", [2, 4])
def test_recordings_at_temperatures_of_their_own_must_be_several(count):
    """Two that differ do so by anything; four that follow the thermometer follow it."""
    begins = (24.0, 28.0, 33.0, 30.0, 36.0, 27.0)[: count + 2]
    shop = shop_of(warming(begins, rise=0.0))
    warm = trial_of(shop, "thermal_drift", 0, (MEASURED, 0.0))
    assert (differs_alone(shop, (), warm) is None) is (count == 4)
