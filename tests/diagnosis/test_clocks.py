"""Which clock counts where a single estimation recording cannot tell; and torques early and late."""

import dataclasses

import numpy as np

from oed.diagnosis.candidates.clocks import by_other_clock
from oed.diagnosis.candidates.judgement import held_out_fault
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.workbench import early_and_late
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis_new.noise.baseline import find_baseline
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import RATE, data_set, once
from tests.diagnosis.shop import shop_of, trial_of


def laid_out(roles):
    """Tables of recordings without repetitions, those for the test known by their clock alone."""
    dataset = data_set(0, repetitions=1, roles=roles)
    # Without a period, as most logs are.
    logs = tuple(map(once, dataset.recordings))
    settings = DiagnosisSettings()
    prepared = prepare(logs)
    own = tuple(p for p in prepared if p.role == "estimation")
    later = tuple(p for p in prepared if p.role != "estimation")
    baseline = find_baseline(TorqueModel.standard(dataset.robot), own)
    return Workshop(baseline, own, (), settings, later=later)


def test_a_single_recording_leaves_the_clock_open():
    shop = laid_out(("estimation", "test"))
    warming = next(t for t in shop.physical if t.key == ("thermal_drift", 0))
    assert warming.values[1] == 1.0  # one clock runs through the session, unless something says no
    turned = by_other_clock(shop, warming)
    assert turned is not None
    assert turned.key == warming.key
    assert turned.values == (warming.values[0], 0.0)
    again = by_other_clock(shop, turned)
    assert again is not None
    assert again.values == warming.values


def test_several_recordings_say_themselves_which_clock_counts():
    shop = laid_out(("estimation", "estimation", "test"))
    warming = next(t for t in shop.physical if t.key == ("thermal_drift", 0))
    assert by_other_clock(shop, warming) is None


def test_what_keeps_no_time_has_no_other_clock():
    shop = laid_out(("estimation", "test"))
    offset = next(t for t in shop.physical if t.name == "torque_offset")
    assert by_other_clock(shop, offset) is None


def test_a_torque_that_comes_first_is_not_late_as_well():
    shop = shop_of(data_set(0, repetitions=1), held=False)
    early, late = (trial_of(shop, "time_delay", None, (x,)) for x in (-5e-3, 5e-3))
    lag = trial_of(shop, "filter_lag", None, (5e-3, 0.5))
    offset = next(t for t in shop.physical if t.name == "torque_offset")
    assert early_and_late([early, offset, lag]) == [early, lag]
    assert early_and_late([late, lag]) == []
    assert early_and_late([early, offset]) == []


def test_where_one_joint_comes_first_and_another_late_the_arm_does_neither():
    dataset = data_set(3, repetitions=2)
    # The motion is periodic, so that the torque wraps.
    recordings = tuple(
        dataclasses.replace(r, tau=np.stack([np.roll(r.tau[:, 0], -3), np.roll(r.tau[:, 1], 3)], 1))
        for r in dataset.recordings
    )
    shop = shop_of(dataclasses.replace(dataset, recordings=recordings), held=False)
    early = trial_of(shop, "time_delay", None, (-3 / RATE,))
    assert held_out_fault(shop, (), early) == "some joints would rather come late"
