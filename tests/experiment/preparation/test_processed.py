"""From a recording to the rows of an estimate: torque and model in one band, chosen from the data."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects import State
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.processed import ProcessedRecording, processed
from oed.experiment.preparation.settings import ProcessingSettings, choose_settings
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from tests.paths import SHARED_DATA, needs_shared_data


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
    rng: np.random.Generator, *, highest: float = 1.0, noise: float = 1e-7, duration: float = 8.0
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
    )


def of(recording: Recording, **changed: object) -> tuple[ProcessedRecording, ProcessingSettings]:
    settings = dataclasses.replace(choose_settings((recording,)), **changed)
    (piece,) = processed(prepare((recording,), settings)[0])
    return piece, settings


@pytest.mark.parametrize("velocity", ["differentiated", "logged"])
def test_motion_and_torque_are_recovered(velocity):
    piece, _ = of(recorded(np.random.default_rng(0)), velocity=velocity)
    q, dq, ddq = multisine(piece.motion.t, 1.0)
    assert np.abs(piece.motion.q - q).max() < 2e-4 * np.abs(q).max()
    assert np.abs(piece.motion.dq - dq).max() < 2e-3 * np.abs(dq).max()
    assert np.abs(piece.tau - 3 * ddq).max() < 5e-3 * np.abs(3 * ddq).max()


def test_both_sides_of_the_model_see_the_same_band():
    """Where the filter bends the torque, it bends the acceleration alike: the ratio stays 3."""
    piece, settings = of(recorded(np.random.default_rng(1), highest=12.0))
    narrow = choose_settings((recorded(np.random.default_rng(1), highest=12.0),), cutoff=8.0)
    piece, _ = of(recorded(np.random.default_rng(1), highest=12.0), band=narrow.band)
    _, _, truth = multisine(piece.motion.t, 12.0)
    assert np.abs(piece.tau - 3 * truth).max() > 0.1 * np.abs(truth).max()
    acceleration = piece.columns(lambda motion: motion.ddq[:, :, None])[:, :, 0]
    assert np.abs(piece.tau - 3 * acceleration).max() < 0.02 * np.abs(piece.tau).max()
    assert settings.cutoff > narrow.cutoff


def test_pieces_of_a_recording_give_what_the_whole_gives(monkeypatch):
    """The mean sign over a step asks for its neighbours, also where one piece ends."""
    monkeypatch.setattr("oed.experiment.preparation.processed.PIECE", 200)
    piece, _ = of(recorded(np.random.default_rng(2)))
    assert len(piece.fine) > 1000

    def signs(motion):
        return State.along(motion).sign(motion.components[1][0])[:, None, None]

    whole, pieces = (piece.columns(signs, remembers=r) for r in (True, False))
    assert np.abs(whole - pieces).max() < 1e-12
    for remembers in (True, False):
        asked = piece.columns(signs, remembers=remembers, rows=slice(7, 90))
        assert np.abs(asked - whole[7:90]).max() < 1e-12


def test_gaps_part_a_recording_into_stretches():
    whole = recorded(np.random.default_rng(3), duration=12.0)
    there = (whole.t < 4.0) | (whole.t > 5.5)
    cut = dataclasses.replace(
        whole, t=whole.t[there], q=whole.q[there], tau=whole.tau[there], dq=None
    )
    (prepared,) = prepare((cut,))
    stretches = processed(prepared)
    assert [s.name for s in stretches] == ["made, stretch 1", "made, stretch 2"]
    assert sum(len(s) for s in stretches) == prepared.valid.sum()
    for stretch in stretches:
        assert not ((stretch.fine.t > 4.0) & (stretch.fine.t < 5.5)).any()
        _, _, ddq = multisine(stretch.motion.t, 1.0)
        assert np.abs(stretch.tau - 3 * ddq).max() < 5e-3 * np.abs(3 * ddq).max()


def test_the_recording_is_left_as_it_was():
    recording = recorded(np.random.default_rng(4))
    before = [x.copy() for x in (recording.t, recording.q, recording.tau)]
    of(recording)
    after = (recording.t, recording.q, recording.tau)
    assert all(np.array_equal(x, y) for x, y in zip(before, after, strict=True))


def test_refuses_what_the_recording_cannot_give():
    recording = recorded(np.random.default_rng(5))
    with pytest.raises(ValueError, match="too short"):
        prepare((recorded(np.random.default_rng(5), duration=0.5),), choose_settings((recording,)))
    without = dataclasses.replace(recording, dq=None)
    logged = dataclasses.replace(choose_settings((without,)), velocity="logged")
    with pytest.raises(ValueError, match="no dq was logged"):
        prepare((without,), logged)
    with pytest.raises(ValueError, match=r"cut-off 400 Hz must lie between .* and 200 Hz"):
        choose_settings((recording,), cutoff=400.0)
    with pytest.raises(ValueError, match=r"cut-off 1e-300 Hz must lie between 0\.\d+ Hz"):
        choose_settings((recording,), cutoff=1e-300)
    with pytest.raises(ValueError, match="role estimation"):
        choose_settings((dataclasses.replace(recording, role="test"),))


@pytest.mark.parametrize("highest", [4.0, 8.0])
def test_the_cutoff_follows_the_motion(highest):
    rng = np.random.default_rng(6)
    settings = choose_settings((recorded(rng, highest=highest, noise=1e-5),))
    assert highest < settings.cutoff < 10 * highest
    assert settings.rate == 1000.0


def test_more_noise_never_raises_the_cutoff():
    cutoffs = [
        choose_settings((recorded(np.random.default_rng(7), highest=10.0, noise=noise),)).cutoff
        for noise in (1e-6, 1e-5, 1e-4, 1e-3)
    ]
    assert cutoffs == sorted(cutoffs, reverse=True)
    assert cutoffs[0] > cutoffs[-1]


def test_every_setting_has_its_reason():
    settings = choose_settings((recorded(np.random.default_rng(8), noise=1e-5),))
    text = "\n".join(settings.reasons)
    for word in ("rate", "cut-off", "filter", "one row", "cut at each end", "velocity", "repeat"):
        assert word in text


@needs_shared_data
@pytest.mark.parametrize(
    ("name", "by_hand"), [("dfki_a0", 10.0), ("staubli_tx40", 20.0), ("franka_panda", 10.0)]
)
def test_the_choice_on_measured_sets_is_near_the_one_by_hand(name, by_hand):
    """The cut-offs of the published baselines, within a factor of two."""
    dataset = read_dataset(SHARED_DATA / name)
    settings = choose_settings(dataset.recordings)
    assert by_hand / 2 <= settings.cutoff <= 2 * by_hand


def test_a_step_in_the_model_is_rounded_like_the_step_in_the_torque():
    """Coulomb friction loses nothing to the filter: it is estimated at its full size."""
    t = np.arange(0.0, 20.0, 0.002)
    q = np.column_stack([np.sin(2.0 * t), np.cos(1.3 * t)])
    dq = np.column_stack([2.0 * np.cos(2.0 * t), -1.3 * np.sin(1.3 * t)])
    recording = Recording("steps", "estimation", t, q, 2.5 * np.sign(dq))
    piece, _ = of(recording)
    sign = piece.columns(lambda motion: np.sign(motion.dq)[:, :, None])[:, :, 0]
    for joint in range(2):
        coulomb = np.linalg.lstsq(sign[:, [joint]], piece.tau[:, joint], rcond=None)[0]
        assert coulomb[0] == pytest.approx(2.5, rel=2e-3)
