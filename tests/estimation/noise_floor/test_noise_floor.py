"""The noise floor of repeated motions: known noise, with what is no noise beside it."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from oed.dynamics.torque_model import TorqueModel
from oed.estimation.noise_floor import baseline, noise_floor
from oed.estimation.noise_floor.autoregression import Autoregression
from oed.estimation.noise_floor.baseline import find_baseline
from oed.estimation.noise_floor.noise_floor import (
    NoiseFloor,
    differences,
    floor_from_repetitions,
    floor_from_smooth_fit,
)
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import COULOMB, NOISE, data_set, once
from tests.diagnosis.arm import RATE as ARM_RATE

RATE = 75.0  # [Hz]
ROWS = 750
HELD = 50  # samples for which a disturbance stays the same
WHITE = Autoregression(np.ones(1), 1.0)  # where nobody asks for the colour
SIZE = np.array([0.2, 0.05])  # [N m] of the noise of two joints


def _floor(change, repetitions: int) -> NoiseFloor:
    """Of two recordings of white noise and a torque that changes; `change(t)` in noise sizes."""
    rng = np.random.default_rng(3)
    t = np.arange(repetitions * ROWS) / RATE
    series = [
        (SIZE * (rng.normal(size=(len(t), 2)) + change(t)[:, None])).reshape(repetitions, ROWS, 2)
        for _ in range(2)
    ]
    trusted = [np.ones(s.shape, dtype=bool) for s in series]
    return floor_from_repetitions(series, trusted, RATE)


@pytest.mark.parametrize(
    ("change", "repetitions"),
    [
        (lambda t: 0 * t, 2),
        (lambda t: 0 * t, 6),
        (lambda t: 0.4 * t, 3),  # a drift by 4 deviations from one repetition to the next
        (lambda t: 8 * np.exp(-t / 40), 8),
        (lambda t: 20.0 * (t > 27), 6),  # a load, taken up within a repetition
    ],
    ids=["two", "steady", "drift", "warming", "load"],
)
def test_a_change_from_repetition_to_repetition_is_no_noise(change, repetitions):
    floor = _floor(change, repetitions)
    # Of 1500 or more rows the deviation is known within 2 %, of those that a load leaves in 4 %.
    assert floor.deviation == pytest.approx(SIZE, rel=0.06)
    for noise, size in zip(floor.noise, SIZE, strict=True):
        assert noise.deviation == pytest.approx(size, rel=0.1)


def test_what_errs_alike_in_all_repetitions_is_noise_of_each():
    """Rounding of encoders that comes again with the motion: no difference shows it."""
    rng = np.random.default_rng(3)
    apart, alike = (
        rng.normal(size=(4, 20_000, 1)),
        np.tile(rng.normal(size=(1, 20_000, 1)), (4, 1, 1)),
    )
    trusted = [np.ones(apart.shape, dtype=bool)]
    floor = floor_from_repetitions([apart], trusted, RATE, [2.0 * alike])
    assert floor.deviation == pytest.approx([np.sqrt(1 + 2.0**2)], rel=0.02)
    # Beside the mean of four, in units of a single one's noise, it is twice as loud.
    assert floor.noise[0].deviation == pytest.approx(np.sqrt(1 + 4 * 2.0**2), rel=0.02)


def test_differences_have_the_size_of_one_repetition():
    noise = np.random.default_rng(0).normal(size=(5, 20000, 1))
    assert np.std(differences(noise)) == pytest.approx(1.0, rel=0.01)
    assert np.std(differences(noise[:2])) == pytest.approx(1.0, rel=0.02)
    steady = np.arange(4.0)[:, None, None] * np.ones((4, 3, 1))
    assert differences(steady) == pytest.approx(np.zeros((2, 3, 1)), abs=1e-12)


@pytest.mark.parametrize("repetitions", [2, 3, 4, 8])
def test_a_floor_knows_with_how_many_degrees_of_freedom_it_was_estimated(monkeypatch, repetitions):
    """Squared deviations of many draws, one a joint, scatter as a chi-squared variable does."""
    monkeypatch.setattr(noise_floor, "fit_autoregression", lambda *_, **__: WHITE)
    noise = np.random.default_rng(6).normal(size=(repetitions, 40, 3000))
    floor = floor_from_repetitions([noise], [np.ones(noise.shape, dtype=bool)], RATE)
    squares = floor.deviation**2
    expected = 2 * np.mean(squares) ** 2 / np.var(squares)
    assert floor.freedom == pytest.approx(np.full(3000, expected), rel=0.1)  # known within 3 %


def test_all_repetitions_count_alike():
    """What repeats must have no part in what differs from repetition to repetition."""
    dataset = data_set(2)
    estimation = prepare(dataset.estimation)
    rows = find_baseline(TorqueModel.standard(dataset.robot), estimation).rows(estimation)
    for start, p in zip(rows.starts, estimation, strict=False):
        weights = rows.weights[start : start + p.rows]
        place = p.band.reach + p.band.factor * np.arange(p.rows)
        assert np.array_equal(p.samples, place)
        phase = p.place_in_period[place] // (2 * p.band.factor)
        turn = (place + 0.5) // ((p.period or np.inf) * p.band.rate)
        for k in np.unique(phase):
            own = [
                weights[(phase == k) & (turn == r)].max(axis=0) for r in np.unique(turn[phase == k])
            ]
            assert np.ptp(own, axis=0) == pytest.approx(np.zeros(2), abs=1e-12)
        # Most rows are left: only the phases of the cut ends and of the whitening's past go.
        assert np.mean(weights.max(axis=1) > 0) > 0.8


def test_floor_is_read_again_beside_what_was_found():
    """A torque that comes and goes is noise until it is known."""
    dataset = data_set(4)
    estimation = prepare(dataset.estimation)
    model = TorqueModel.standard(dataset.robot)
    clean = find_baseline(model, estimation)
    rng = np.random.default_rng(1)
    known, disturbed = [], []
    for p in estimation:
        strange = np.zeros_like(p.fine_torque)
        held = np.repeat(rng.normal(size=len(p.motion) // HELD + 1), HELD)
        strange[:, 0] = NOISE[0] * held[: len(p.motion)]
        known.append(strange)
        changed = p.fine_torque + strange
        disturbed.append(_with_torque(p, changed))
    disturbed = tuple(disturbed)
    loud = find_baseline(model, disturbed)
    assert loud.floor.deviation[0] > 3 * clean.floor.deviation[0]
    again = loud.with_model(loud.model, disturbed, known)
    # The base model is fitted to the disturbed torque: what that costs repeats with the motion.
    assert again.floor.deviation == pytest.approx(clean.floor.deviation, rel=0.1)


def _with_torque(prepared, fine_torque):
    return dataclasses.replace(
        prepared, fine_torque=fine_torque, torque=prepared.band.apply(fine_torque)
    )


def test_a_floor_read_beside_what_is_known_is_that_of_data_without_it():
    def spring(q, dq=None, ddq=None):
        return np.stack([4.0 * q[:, 0], np.zeros(len(q))], axis=1)

    bare, sprung = (
        prepare(data_set(0, extra=extra, roles=("estimation",)).recordings)
        for extra in (None, spring)
    )
    expected = find_baseline(TorqueModel.standard(data_set(0).robot), bare)
    known = [spring(p.motion.q) for p in sprung]
    found = expected.with_model(expected.model, sprung, known)
    # What is left are reversals at other samples: the torque differs by 4 N m/rad times 1e-5 rad.
    assert found.coulomb == pytest.approx(expected.coulomb, rel=1e-3)
    assert found.floor.deviation == pytest.approx(expected.floor.deviation, rel=1e-3)
    unaware = expected.with_model(expected.model, sprung)
    assert unaware.coulomb != pytest.approx(expected.coulomb, rel=1e-3)


def test_steps_of_encoders_are_loud_at_reversals_alone():
    """Beside dry friction: rows that are trusted are those of the repetition that they stand in."""
    dataset = data_set(
        2,
        repetitions=5,
        step=5e-5,
        roles=("estimation",),
        extra=lambda q, dq, ddq: 20 * COULOMB * np.sign(dq),
    )
    (prepared,) = prepare(dataset.recordings)
    floor = find_baseline(TorqueModel.standard(dataset.robot), (prepared,)).floor
    sizes = zip(floor.noise, floor.deviation, strict=True)
    # Where joints move, steps of 0.05 mrad add a tenth to the noise.
    assert [noise.deviation / size for noise, size in sizes] == pytest.approx([1, 1], abs=0.15)


def test_few_trusted_rows_leave_few_degrees_of_freedom(monkeypatch):
    """Each function of a rich fit takes a degree from the rows that were fitted, not from all."""
    every = 6

    def few(recordings, _joint, _coulomb, _deviation):
        return np.concatenate([np.arange(r.rows) % every == 0 for r in recordings])

    monkeypatch.setattr(baseline, "_trusted_rows", few)
    found, taps = [], np.zeros(0)
    for seed in range(6):
        dataset = data_set(seed, roles=("estimation",), repetitions=2)
        (whole,) = dataset.recordings
        prepared = prepare((once(whole),))
        found.append(find_baseline(TorqueModel.standard(dataset.robot), prepared).floor.deviation)
        taps = prepared[0].band.taps
    true = NOISE * np.sqrt(taps @ taps)
    # 6 times some 45 degrees of freedom: the deviation is known within 4.3 %.
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(true, rel=0.13)


@pytest.mark.parametrize("enough", [True, False])
def test_rows_that_are_too_few_for_the_functions_give_way_to_those_of_a_rougher_fit(
    monkeypatch, enough
):
    """A short log: as the fit improves, ever more rows look like badly timed reversals."""
    every, asked = 6 if enough else 60, Counter()

    def fewer_and_fewer(recordings, joint, _coulomb, _deviation):
        asked[joint] += 1
        step = every if asked[joint] % 2 else 60
        return np.concatenate([np.arange(r.rows) % step == 0 for r in recordings])

    monkeypatch.setattr(baseline, "_trusted_rows", fewer_and_fewer)
    dataset = data_set(3, roles=("estimation",), repetitions=2)
    prepared = prepare((once(dataset.recordings[0]),))
    model = TorqueModel.standard(dataset.robot)
    if not enough:
        with pytest.raises(ValueError, match="too few to tell noise"):
            find_baseline(model, prepared)
        return
    # Some 45 degrees of freedom: the deviation is known within 11 %, here to three times that.
    found = find_baseline(model, prepared).floor.deviation
    assert found == pytest.approx(NOISE * np.linalg.norm(prepared[0].band.taps), rel=0.33)


def test_recordings_too_short_to_tell_noise_from_motion_are_refused():
    """A rich fit of a second passes through every sample: no noise, and everything significant."""
    dataset = data_set(1, roles=("estimation",), repetitions=1)
    (whole,) = dataset.recordings
    short = once(whole, slice(0, round(1.6 * ARM_RATE)))
    prepared = prepare((short,))
    with pytest.raises(ValueError, match="record longer, or repeat the motion"):
        find_baseline(TorqueModel.standard(dataset.robot), prepared)


def test_a_blow_that_the_arm_takes_is_no_noise():
    rate, rng = 50.0, np.random.default_rng(0)
    quiet = rng.normal(size=(3000, 2)) * [0.05, 0.01]
    struck = quiet.copy()
    struck[1000:1030] += [5.0, 3.0]  # for six tenths of a second
    trusted, ones = [np.ones(quiet.shape, dtype=bool)], np.ones(2)
    floors = [floor_from_smooth_fit([x], trusted, ones, ones, rate) for x in (quiet, struck)]
    usual, after_blow = (floor.deviation for floor in floors)
    # Without the seconds that were struck a sixtieth of the rows is left out.
    assert after_blow == pytest.approx(usual, rel=0.02)


def test_a_blow_at_one_joint_is_no_noise_of_it_though_another_joint_is_hardly_trusted():
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(4000, 2))
    noise[2000:2400, 0] *= 30
    trusted = np.ones(noise.shape, dtype=bool)
    trusted[:, 1] = np.arange(len(noise)) % 3 == 0  # of every half second too little
    floor = floor_from_smooth_fit([noise], [trusted], np.ones(2), np.ones(2), RATE)
    # 3600 rows tell a deviation within 1.2 %, whole noisy blocks less a little more.
    np.testing.assert_allclose(floor.deviation, 1.0, rtol=0.05)
