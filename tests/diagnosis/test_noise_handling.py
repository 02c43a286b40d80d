"""What decides a diagnosis before any effect is tried: direction, gaps, floor, restraint."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import Context
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import widths_of
from oed.estimation.noise_floor.baseline import find_baseline
from oed.experiment.preparation.direction import uncertain_direction
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis import arm
from tests.diagnosis.arm import COULOMB, data_set


def _baseline(dataset):
    prepared = prepare(dataset.estimation)
    return find_baseline(TorqueModel.standard(dataset.robot), prepared), prepared


def test_reads_off_how_sharply_friction_turns():
    width = 0.03

    def softer(q, dq, ddq):
        return COULOMB * (np.tanh(dq / width) - np.sign(dq))

    baseline, _ = _baseline(data_set(1, extra=softer))
    # Joint 1 has five times the noise: it does not show a difference.
    assert widths_of(baseline.model)[1] == pytest.approx(width, rel=0.1)


def test_a_sharp_sign_stays_sharp():
    baseline, prepared = _baseline(data_set(1))
    assert max(widths_of(baseline.model)) < 3 * prepared[0].sign_noise.max()


def test_recordings_may_have_periods_of_their_own(monkeypatch):
    long = data_set(5, roles=("estimation",))
    monkeypatch.setattr(arm, "PERIOD", 8.0)
    short = data_set(6, roles=("estimation",))
    second = dataclasses.replace(short.recordings[0], name="short")
    both = dataclasses.replace(long, recordings=(*long.recordings, second))
    baseline, prepared = _baseline(both)
    assert [p.period for p in prepared] == [10.0, 8.0]
    share = prepared[0].band.cutoff / (0.5 * arm.RATE)
    # Each joint's noise is white up to half the sampling rate; the band keeps its share.
    assert baseline.floor.deviation == pytest.approx(arm.NOISE * np.sqrt(share), rel=0.15)


def test_a_gap_in_the_log_is_no_fast_motion():
    dataset = data_set(2)
    whole = prepare(dataset.estimation)[0]
    cut = tuple(_with_gaps(recording) for recording in dataset.estimation)
    assert prepare(cut)[0].band.cutoff == pytest.approx(whole.band.cutoff, rel=0.25)


def _with_gaps(recording):
    """The last fifth of every repetition left out."""
    kept = np.mod(recording.t, recording.period) < 0.8 * recording.period
    columns = {name: getattr(recording, name)[kept] for name in ("t", "q", "tau", "repetition")}
    return dataclasses.replace(recording, **columns)


def test_a_gap_is_crossed_as_smoothly_as_an_arm_moves():
    dataset = data_set(2)
    whole = prepare(dataset.estimation)[0]
    cut = prepare(tuple(_with_gaps(recording) for recording in dataset.estimation))[0]
    jumps = [np.abs(np.diff(p.motion.ddq, axis=0)).max(axis=0) for p in (whole, cut)]
    # A straight line across would make an impulse of the acceleration at both ends.
    assert (jumps[1] < 3 * jumps[0]).all()
    assert not cut.recorded.all()


def test_noise_floor_without_repetitions_is_the_noise_whatever_the_model_lacks():
    def product(q, dq, ddq):
        return np.stack([np.zeros(len(q)), 0.8 * q[:, 0] * dq[:, 1]], axis=1)

    roles = ("estimation", "estimation", "validation", "test")
    clean, _ = _baseline(data_set(3, repetitions=1, roles=roles))
    lacking, prepared = _baseline(data_set(3, repetitions=1, roles=roles, extra=product))
    ratio = lacking.floor.deviation / clean.floor.deviation
    assert ratio == pytest.approx([1.0, 1.0], abs=0.15)
    # And it is that of the white noise that was put in, within the band of the rows.
    band = prepared[0].band
    share = np.sqrt(np.sum(band.taps**2) / band.logged)
    assert clean.floor.deviation == pytest.approx(np.array([0.5, 0.1]) * share, rel=0.12)


def test_a_joint_that_lingers_has_no_known_direction():
    prepared = prepare(data_set(6).estimation)[0]
    motion, typical = prepared.motion, np.sqrt(np.mean(prepared.motion.dq[:, 1] ** 2))
    before = uncertain_direction(prepared, 1)
    fast = np.flatnonzero(np.abs(motion.dq[:, 1]) > typical)
    middle = int(fast[len(fast) // 2])
    rate = prepared.band.rate
    marked = {}
    for seconds in (0.02, 0.5):
        dq = motion.dq.copy()
        stretch = slice(middle, middle + round(seconds * rate))
        dq[stretch, 1] = 0.01 * typical
        # It creeps one way, far above what the encoder's noise makes of standstill.
        assert 0.01 * typical > 3 * prepared.sign_noise[1]
        held = dataclasses.replace(motion, dq=dq)
        marked[seconds] = uncertain_direction(dataclasses.replace(prepared, motion=held), 1)[
            stretch
        ]
    assert not before[middle]
    assert not marked[0.02].any()
    assert marked[0.5].all()


def test_recordings_of_one_clock_make_a_session():
    dataset = data_set(5)
    model = TorqueModel.standard(dataset.robot)
    parameters = np.ones(len(model.parameters))
    motions = [p.motion for p in prepare(dataset.estimation)]
    restarted = dataclasses.replace(motions[1], t=motions[0].t[: len(motions[1])])
    assert Context.of(model, parameters, [motions[0], restarted]).session is None
    later = dataclasses.replace(motions[1], t=motions[1].t + 100.0)
    session = Context.of(model, parameters, [motions[0], later]).session
    assert session == (motions[0].t[0], later.t[-1])
