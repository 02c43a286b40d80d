"""What changes once in a session, in a recording of its own clock: where it is put, and found."""

import dataclasses
from itertools import count

import numpy as np
import pytest

from oed.diagnosis.candidates.crests import climbed
from oed.diagnosis.candidates.within import comes_at_once
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.terms.scores import score
from oed.diagnosis.terms.trials import moved, white_group
from oed.diagnosis_new.rows.autoregression import Autoregression
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.entries.payload import FOR_GOOD
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.thermal import ThermalDrift
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.mean_repetition import mean_of_repetitions
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import COULOMB, LENGTH, PERIOD, RATE, VISCOUS, data_set, once, rigid
from tests.diagnosis.shop import shop_of

MASS, REACH = 1.5, 0.25  # [kg], [m] from the second joint
TAKEN_UP = 17.0  # [s] in the second recording
WARM = 8.0  # [s] in which cold friction falls to a third


def load_from(taken_up=TAKEN_UP, recording=1):
    """Torque of a point mass on the second link, from a moment of a recording on."""
    numbers = count()

    def torque(q, dq, ddq):
        number = next(numbers)
        own = (MASS * LENGTH**2, MASS * REACH, 0.0, MASS * REACH**2)
        t = np.arange(len(q)) / RATE
        held = (t >= taken_up) if number == recording else np.full(len(t), number > recording)
        return held[:, None] * rigid(q, dq, ddq, own)

    return torque


def shifted(dataset, gap):
    """The same on one clock, with pauses."""
    recordings = []
    start = 100.0
    for r in dataset.recordings:
        recordings.append(dataclasses.replace(r, t=r.t + start))
        start += r.duration + gap
    return tuple(recordings)


def test_recordings_of_their_own_clocks_lie_end_to_end_as_they_are_listed():
    dataset = data_set(0)
    prepared = prepare(dataset.recordings)
    starts = [p.motion.t[0] for p in prepared]
    assert np.diff(starts) == pytest.approx(3 * PERIOD, abs=0.01)
    # Where the log has a clock that goes on, time stays as it was logged.
    apart = prepare(shifted(dataset, 5.0))
    assert np.diff([p.motion.t[0] for p in apart]) == pytest.approx(3 * PERIOD + 5, abs=0.01)
    assert apart[0].motion.t[0] == pytest.approx(100.0, abs=0.2)


def unrepeated(dataset):
    """The same without a word of repetitions."""
    return dataclasses.replace(dataset, recordings=tuple(map(once, dataset.recordings)))


@pytest.mark.parametrize(
    ("recordings", "gap", "ordered"),
    [(unrepeated, None, False), (lambda d: d, None, True), (unrepeated, 5.0, True)],
)
def test_clocks_or_repetitions_tell_how_recordings_follow_one_another(recordings, gap, ordered):
    dataset = recordings(data_set(0))
    if gap is not None:
        dataset = dataclasses.replace(dataset, recordings=shifted(dataset, gap))
    assert shop_of(dataset).context.ordered is ordered


@pytest.mark.parametrize("kind", ["payload", "drift"])
def test_columns_of_the_mean_repetition_are_the_mean_of_all(kind):
    dataset = data_set(0, roles=("estimation", "estimation"))
    prepared = prepare(dataset.recordings)
    robot = dataset.robot
    effect = {
        "payload": PayloadChange(robot, 1, 44.0, (1, 9), prepared[0].motion.t[0]),
        "drift": ThermalDrift(1, 12.0),
    }[kind]
    noise = (Autoregression(np.ones(1), 1.0),) * 2
    for p in prepared:
        mean, repetitions = mean_of_repetitions(p)
        assert repetitions == 3
        found, whole = (
            white_group(effect, Rows((x,), noise, (1.0,), np.ones((x.rows, 2))))[1]
            for x in (mean, p)
        )
        step = round(PERIOD * p.band.analysis_rate)
        expected = np.mean([whole[k * step : k * step + len(found)] for k in range(3)], axis=0)
        # Encoder noise differs between repetitions; the gate opens at the same sample.
        assert found == pytest.approx(expected, abs=0.02 * np.abs(expected).max() + 1e-12)


# At the end of the first recording it looks much like one that is taken up in the pause after it.
@pytest.mark.parametrize(("recording", "taken_up"), [(1, TAKEN_UP), (0, 23.0)])
def test_a_load_that_is_taken_up_in_one_recording_and_stays_is_found(recording, taken_up):
    dataset = data_set(3, extra=load_from(taken_up, recording))
    settings = DiagnosisSettings(
        surrogates=39, bootstrap=40, candidates=("payload_change", "thermal_drift")
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    (effect,) = found.effects
    assert effect.name == "payload_change"
    values = {p.name: p.value for p in effect.parameters}
    assert values["moment"] == pytest.approx(3 * PERIOD * recording + taken_up, abs=0.02)
    assert values["load_mx_2"] == pytest.approx(MASS * REACH, rel=0.05)
    after = next(p.after for p in found.proof if p.role == "test")
    assert np.all(after < 1.2 * found.noise_floor)


@pytest.mark.parametrize(("taken_up", "tolerance"), [(TAKEN_UP, 0.02), (0.0, 1.0)])
def test_a_load_is_told_by_recordings_that_differ_by_nothing_else(taken_up, tolerance):
    dataset = unrepeated(data_set(3, extra=load_from(taken_up)))
    settings = DiagnosisSettings(
        surrogates=39, bootstrap=40, candidates=("payload_change", "thermal_drift")
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    (effect,) = found.effects
    assert effect.name == "payload_change"
    values = {p.name: p.value for p in effect.parameters}
    # What lies between the last row of one recording and the first of the next is all the same.
    assert values["moment"] == pytest.approx(3 * PERIOD + taken_up, abs=tolerance)
    assert values["load_mx_2"] == pytest.approx(MASS * REACH, rel=0.05)


def test_recordings_of_no_known_order_that_differ_by_anything_else_name_no_load():
    number = count()

    def rougher(q, dq, ddq):
        """Friction of both joints, in all recordings but the first."""
        return (next(number) > 0) * np.array([1.0, 0.3]) * np.sign(dq)

    dataset = unrepeated(data_set(3, extra=rougher))
    settings = DiagnosisSettings(surrogates=39, bootstrap=40, candidates=("payload_change",))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert not found.effects


def test_a_load_that_is_taken_up_between_two_recordings_is_found():
    """No repetition differs from another: only the recordings do."""
    dataset = data_set(3, extra=load_from(taken_up=0.0))
    settings = DiagnosisSettings(
        surrogates=39, bootstrap=40, candidates=("payload_change", "thermal_drift", "joint_spring")
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    (effect,) = found.effects
    assert effect.name == "payload_change"
    values = {p.name: p.value for p in effect.parameters}
    # Edges of 0.1 s are cut at each end of a recording.
    assert values["moment"] == pytest.approx(3 * PERIOD, abs=0.5)
    assert values["load_mx_2"] == pytest.approx(MASS * REACH, rel=0.05)
    after = next(p.after for p in found.proof if p.role == "test")
    assert np.all(after < 1.2 * found.noise_floor)


def test_a_pause_of_the_log_within_a_repetition_is_no_obstacle():
    dataset = data_set(4, roles=("estimation", "estimation", "validation"))
    first = dataset.recordings[0]
    assert first.repetition is not None
    kept = (first.t < 13.0) | (first.t > 13.4)
    paused = dataclasses.replace(
        first,
        t=first.t[kept],
        q=first.q[kept],
        tau=first.tau[kept],
        repetition=first.repetition[kept],
    )
    dataset = dataclasses.replace(dataset, recordings=(paused, *dataset.recordings[1:]))
    settings = DiagnosisSettings(surrogates=39, bootstrap=40, candidates=("joint_spring",))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert found.verdict == "nothing found"
    assert np.all(found.noise_floor > 0)


def test_a_moment_is_found_from_any_swing_of_the_arm():
    """Every swing has a crest of its own: a simplex alone stays on that where it begins."""
    shop = shop_of(data_set(3, extra=load_from(recording=0), roles=("estimation", "validation")))
    trials = [t for t in shop.physical if t.name == "payload_change"]
    layout = shop.layout(trials[0])
    fit = shop.fit([], layout).fit
    band = shop.estimation[0].band
    truth = TAKEN_UP - band.edge  # since the first sample that is used
    for offset in (-6.0, 4.0):
        values = (truth + offset, *trials[0].values[1:])
        begun = dataclasses.replace(trials[0], values=values)
        there = score(moved(begun, layout.rows, shop.context), fit)
        moment = climbed(shop, there, fit).trial.values[0]
        # To the rows before and after it.
        assert moment == pytest.approx(truth, abs=2 / band.analysis_rate)


@pytest.mark.parametrize("share", [0.4, -0.4])
def test_a_joint_that_starts_anew_in_each_recording_is_told_by_the_next(share):
    """Warming up, or cooling: the only estimation recording cannot tell which clock it goes by."""

    def torque(q, dq, ddq):
        t = np.arange(len(q)) / RATE
        friction = COULOMB * np.sign(dq) + VISCOUS * dq
        return share * np.exp(-t / 9.0)[:, None] * friction * [1.0, 0.0]

    dataset = data_set(3, extra=torque, roles=("estimation", "validation", "test"))
    settings = DiagnosisSettings(
        surrogates=39, bootstrap=40, candidates=("payload_change", "thermal_drift", "torque_gain")
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert [(e.name, e.joint) for e in found.effects] == [("thermal_drift", 0)]
    values = {p.name: p for p in found.effects[0].parameters}
    assert values["clock"].value == 0.0
    assert values["time_constant"].value == pytest.approx(9.0, abs=4 * values["time_constant"].std)
    after = next(p.after for p in found.proof if p.role == "test")
    assert np.all(after < 1.2 * found.noise_floor)


def cold_at_each_start(q, dq, ddq):
    """Friction of the first joint that is gone some time after every start."""
    t = np.arange(len(q)) / RATE
    return np.exp(-t / WARM)[:, None] * np.sign(dq) * np.array([1.5, 0.0])


@pytest.fixture(scope="module")
def cold():
    """One estimation recording, whose clock says nothing of the next."""
    dataset = data_set(4, extra=cold_at_each_start, roles=("estimation", "validation"))
    shop = shop_of(dataset, candidates=("thermal_drift", "joint_spring"))
    drift = next(t for t in shop.physical if t.key == ("thermal_drift", 0))
    values = (0.5 * WARM, 0.0)
    there = dataclasses.replace(drift, values=values)
    return shop, moved(there, shop.full.rows, shop.context, contrast=drift.contrast)


def test_a_drift_keeps_its_clock_when_its_time_constant_is_looked_for_again(cold):
    shop, drift = cold
    fit = shop.fit((), shop.full).fit
    found = climbed(shop, score(drift, fit), fit)
    assert found.trial.values == (pytest.approx(WARM, rel=0.2), 0.0)


def test_what_repetitions_differ_by_foretells_from_all_of_them():
    """A load that is held in some repetitions is, in their mean, a heavier link."""
    dataset = data_set(4, extra=load_from(14.0, 0), roles=("estimation", "validation"))
    shop = shop_of(dataset, candidates=("payload_change", "joint_spring"))
    load = next(t for t in shop.physical if t.key == ("payload_change", None))
    there = dataclasses.replace(load, values=(14.0, 1.0, FOR_GOOD))
    known = moved(there, shop.full.rows, shop.context, contrast=load.contrast)
    spring = next(t for t in shop.physical if t.key == ("joint_spring", 0))
    of_mean = shop.validation_rms(shop.fit([known], shop.mean, bend=False), as_it_is=True)
    without, beside = shop.foretold([known], [known, spring], as_it_is=True)
    assert without is not None
    assert of_mean is not None
    assert without[0] < 0.7 * of_mean[0]
    # A spring that is not there changes nothing.
    assert beside == pytest.approx(without, rel=0.02)


@pytest.mark.parametrize("at_once", [True, False])
def test_friction_that_jumps_is_no_joint_that_warms(at_once):
    """From a moment on in every recording, or as it cools."""
    t = np.arange(int(3 * PERIOD * RATE)) / RATE
    more = np.where(t > TAKEN_UP, 1.0, 0.0) if at_once else np.exp(-t / WARM)

    def rougher(q, dq, ddq):
        return np.stack([0 * t, 0.4 * more * np.sign(dq[:, 1])], axis=1)

    shop = shop_of(data_set(4, extra=rougher, roles=("estimation", "validation")))
    fit = shop.fit([], shop.full).fit
    warm = [t for t in shop.physical if t.key == ("thermal_drift", 1)]
    best = max((score(t, fit) for t in warm), key=lambda s: s.gain).trial
    assert (comes_at_once(shop, [], best) is not None) is at_once
