"""Friction of a shape that nobody declared, and a sign that turns at a speed that nobody knows."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects import Coulomb
from oed.dynamics.effects.actuator import TorqueGain
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.friction_curve import SHARES, with_friction_curve
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.velocity_sign import with_widths
from oed.estimation.load.known_arm import KnownArm
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.payload import estimate_payload
from oed.estimation.sign_width import WIDTHS, choose_sign_widths
from tests.estimation.load.carrying_arm import (
    COULOMB,
    FRAME,
    MASS,
    MODEL,
    known_interval,
    recording,
)


def widths(model):
    return [e.width for e in model.effects if isinstance(e, Coulomb)]


@pytest.mark.parametrize("true", [WIDTHS[3], WIDTHS[5]])
def test_the_width_that_made_the_data_is_chosen(true):
    rng = np.random.default_rng(0)
    log = recording(rng, 10.0, noise=0.3, is_loaded=False)
    base = base_parameters(MODEL)

    def columns(width):
        model = with_widths(MODEL, [width] * 6)
        return log.columns(lambda m: base.reduce(model.columns(m)))

    flat = columns(0.02).reshape(-1, len(base))
    found = np.linalg.lstsq(flat, log.tau.ravel(), rcond=1e-8)[0]
    made = columns(true) @ found + 0.01 * rng.standard_normal(log.tau.shape)
    log = dataclasses.replace(log, tau=made)
    assert widths(choose_sign_widths(MODEL, base.columns, [log])) == [true] * 6
    # Seen through a sensor that shows nine tenths of a joint's torque.
    seen = MODEL.with_measurement(TorqueGain(1, 0.9, 0.0, ReferenceTorque(MODEL.robot)))
    log = dataclasses.replace(log, tau=log.tau * np.where(np.arange(6) == 1, 0.9, 1.0))
    assert widths(choose_sign_widths(seen, base.columns, [log])) == [true] * 6


def test_curves_are_added_once_and_turn_as_coulomb_friction_does():
    model = with_friction_curve(MODEL)
    added = [e for e in model.effects if isinstance(e, Stribeck)]
    assert len(added) == 6 * len(SHARES)
    assert {e.width for e in added} == {0.02}
    assert with_friction_curve(model) is model


def test_undeclared_stribeck_friction_costs_a_load_little():
    rng = np.random.default_rng(8)
    logs = [recording(rng, seconds, is_loaded=x) for seconds, x in ((20.0, False), (10.0, True))]
    hidden = [
        log.columns(lambda m: (np.tanh(m.dq / 0.02) * np.exp(-((m.dq / 0.15) ** 2)))[:, :, None])
        for log in logs
    ]
    logs = [
        dataclasses.replace(log, tau=log.tau + 0.4 * COULOMB * more[:, :, 0])
        for log, more in zip(logs, hidden, strict=True)
    ]
    plain, curved = (
        estimate_payload(
            KnownArm.from_recordings(LoadedModel.bare(model, FRAME), logs[:1]), logs[1:]
        )
        for model in (MODEL, with_friction_curve(MODEL))
    )
    narrow = known_interval(curved["mass"])
    assert np.ptp(narrow) < 0.7 * np.ptp(known_interval(plain["mass"]))
    low, high = narrow
    assert low <= MASS <= high
