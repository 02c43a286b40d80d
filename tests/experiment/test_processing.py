"""From a recording to motion and torque in one band, with settings that suit the data."""

import dataclasses

import numpy as np
import pytest

from oed.experiment.choose_settings import choose_settings
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessingSettings, process
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from oed.robot import imi_scara
from tests.paths import SHARED_DATA, needs_shared_data

SETTINGS = ProcessingSettings(rate=1000.0, cutoff=20.0, decimation=5, trim=0.2)


def multisine(t: np.ndarray, highest: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration of two joints, five sines up to `highest` [Hz]."""
    w = 2 * np.pi * highest * np.arange(1, 6) / 5
    amplitude = np.array([[0.3, -0.2], [0.1, 0.2], [-0.1, 0.1], [0.05, 0.1], [0.1, -0.1]])
    phase = np.outer(t, w)
    return (
        np.sin(phase) @ amplitude,
        np.cos(phase) @ (w[:, None] * amplitude),
        -np.sin(phase) @ (w[:, None] ** 2 * amplitude),
    )


def recorded(
    rng: np.random.Generator, *, highest: float = 1.0, noise: float = 0.0, duration: float = 8.0
) -> Recording:
    t = np.cumsum(rng.uniform(0.0008, 0.0012, int(1000 * duration)))
    q, dq, ddq = multisine(t, highest)
    return Recording(
        name="made",
        role="estimation",
        t=t,
        q=q + noise * rng.normal(size=q.shape),
        tau=3 * ddq,
        dq=dq,
        repetition=(t > 4).astype(int),
    )


@pytest.mark.parametrize("velocity", ["differentiated", "logged"])
def test_motion_and_torque_are_recovered(velocity):
    settings = dataclasses.replace(SETTINGS, velocity=velocity)
    processed = process(recorded(np.random.default_rng(0)), settings)
    q, dq, ddq = multisine(processed.motion.t, 1.0)
    assert np.abs(processed.motion.q - q).max() < 1e-4 * np.abs(q).max()
    assert np.abs(processed.motion.dq - dq).max() < 1e-4 * np.abs(dq).max()
    assert np.abs(processed.motion.ddq - ddq).max() < 1e-4 * np.abs(ddq).max()
    assert np.abs(processed.tau - 3 * ddq).max() < 1e-4 * np.abs(3 * ddq).max()


def test_both_sides_of_the_model_see_the_same_band():
    """Where the filter bends the torque, it bends the acceleration alike: the ratio stays 3."""
    processed = process(recorded(np.random.default_rng(1), highest=20.0), SETTINGS)
    _, _, truth = multisine(processed.motion.t, 20.0)
    assert np.abs(processed.tau - 3 * truth).max() > 0.1 * np.abs(truth).max()
    acceleration = processed.columns(lambda motion: motion.ddq[:, :, None])[:, :, 0]
    error = np.abs(processed.tau - 3 * acceleration).max()
    # The derivatives lose nothing that the band holds.
    assert error < 1e-4 * np.abs(processed.tau).max()


def test_grid_trim_and_repetition():
    recording = recorded(np.random.default_rng(2))
    processed = process(recording, SETTINGS)
    t = processed.motion.t
    assert processed.rate == 200.0
    assert np.allclose(np.diff(t), 0.005, rtol=0, atol=1e-9)
    assert t[0] - recording.t[0] == pytest.approx(0.2, abs=1e-9)
    assert 0.2 <= recording.t[-1] - t[-1] < 0.2 + 0.007
    assert processed.repetition is not None
    assert recording.repetition is not None
    assert np.array_equal(
        processed.repetition,
        recording.repetition[np.searchsorted(recording.t, t + 1e-9, side="right") - 1],
    )


def test_the_recording_is_left_as_it_was():
    recording = recorded(np.random.default_rng(3))
    assert recording.dq is not None
    before = [x.copy() for x in (recording.t, recording.q, recording.tau, recording.dq)]
    process(recording, SETTINGS)
    after = (recording.t, recording.q, recording.tau, recording.dq)
    assert all(np.array_equal(x, y) for x, y in zip(before, after, strict=True))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"cutoff": 500.0}, "half the rate"),
        ({"decimation": 0}, "at least 1"),
        ({"decimation": 50}, "cannot carry"),
        ({"trim": -1.0}, "not be negative"),
    ],
)
def test_refuses_settings_that_contradict_each_other(changed, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(SETTINGS, **changed)


def test_refuses_what_the_recording_cannot_give():
    recording = recorded(np.random.default_rng(4), duration=0.3)
    with pytest.raises(ValueError, match="too short"):
        process(recording, SETTINGS)
    without = dataclasses.replace(recording, dq=None)
    with pytest.raises(ValueError, match="no dq was logged"):
        process(without, dataclasses.replace(SETTINGS, velocity="logged"))


def of_recordings(*recordings: Recording) -> DataSet:
    return DataSet("made", "", "", imi_scara(), "measured", recordings=recordings)


@pytest.mark.parametrize("highest", [1.0, 4.0, 12.0])
def test_the_cutoff_follows_the_motion(highest):
    rng = np.random.default_rng(5)
    settings = choose_settings(of_recordings(recorded(rng, highest=highest, noise=1e-5)))
    assert highest < settings.cutoff < 10 * highest
    assert settings.rate == 1000.0


def test_more_noise_never_raises_the_cutoff():
    cutoffs = [
        choose_settings(of_recordings(recorded(np.random.default_rng(6), noise=noise))).cutoff
        for noise in (1e-7, 1e-6, 1e-5, 1e-4)
    ]
    assert cutoffs == sorted(cutoffs, reverse=True)
    assert cutoffs[0] > cutoffs[-1]


def test_every_setting_has_its_reason_and_can_be_overridden():
    settings = choose_settings(of_recordings(recorded(np.random.default_rng(7), noise=1e-5)))
    for word in ("rate", "cut-off", "filter", "sample", "trim", "velocity", "repeat", "interpol"):
        assert word in str(settings)
    other = settings.with_cutoff(2 * settings.cutoff)
    assert other.cutoff == 2 * settings.cutoff
    assert other.trim <= settings.trim
    assert other.output_rate >= 10 * other.cutoff


def test_needs_a_recording_for_estimation():
    recording = dataclasses.replace(recorded(np.random.default_rng(8)), role="test")
    with pytest.raises(ValueError, match="no recording with role estimation"):
        choose_settings(of_recordings(recording))


@needs_shared_data
@pytest.mark.parametrize(
    ("name", "rate", "by_hand"),
    [("dfki_a0", 300.0, 10.0), ("staubli_tx40", 5000.0, 20.0), ("franka_panda", 1000.0, 10.0)],
)
def test_the_choice_on_measured_sets_is_near_the_one_by_hand(name, rate, by_hand):
    """The cut-offs of the published baselines, within a factor of two."""
    dataset = read_dataset(SHARED_DATA / name)
    settings = choose_settings(dataset)
    assert settings.rate == rate
    assert by_hand / 2 <= settings.cutoff <= 2 * by_hand
    for recording in dataset.recordings:
        processed = process(recording, settings)
        assert len(processed) > 50
        assert np.abs(processed.motion.dq).max() < 20  # [rad/s]


def test_a_step_in_the_model_is_rounded_like_the_step_in_the_torque():
    """Coulomb friction loses nothing to the filter: it is estimated at its full size."""
    t = np.arange(0.0, 20.0, 0.002)
    q = np.column_stack([np.sin(2.0 * t), np.cos(1.3 * t)])
    dq = np.column_stack([2.0 * np.cos(2.0 * t), -1.3 * np.sin(1.3 * t)])
    recording = Recording("steps", "estimation", t, q, 2.5 * np.sign(dq))
    settings = ProcessingSettings(rate=500.0, cutoff=2.0, decimation=25, trim=1.0)
    processed = process(recording, settings)
    sign = processed.columns(lambda motion: np.sign(motion.dq)[:, :, None])[:, :, 0]
    for joint in range(2):
        coulomb = np.linalg.lstsq(sign[:, [joint]], processed.tau[:, joint], rcond=None)[0]
        # Reversals fall between samples, by up to half of a fine one.
        assert coulomb[0] == pytest.approx(2.5, rel=2e-3)
