"""Temperatures of a log: smoothed, one for each joint."""

import dataclasses

import numpy as np
import pytest

from oed.experiment.dataset import DataSet
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from oed.experiment.temperature import (
    joint_temperature,
    missing_notes,
    temperature_of,
    thermometer_notes,
)
from oed.experiment.write_dataset import write_dataset
from oed.robot.builtin import imi_scara

RATE = 200.0  # [Hz]
T = np.arange(0.0, 60.0, 1 / RATE)
COLD, RISE, TIME_CONSTANT = 24.0, 8.0, 20.0


def recording(*sensors):
    """Two joints that move, and thermometers."""
    q = np.stack([np.sin(T), 0.7 * np.cos(1.3 * T)], axis=1)
    tau = 2.0 * q
    return Recording("log", "estimation", T, q, tau, temperature=np.stack(sensors, axis=1))


def warming(rng):
    """What a thermometer that shows tenths says of a joint that warms, and the truth."""
    true = COLD + RISE * (1 - np.exp(-T / TIME_CONSTANT))
    return np.round(true + 0.05 * rng.standard_normal(len(T)), 1), true


def test_steps_of_the_thermometer_are_smoothed_and_the_warmth_is_kept():
    shown, true = warming(np.random.default_rng(0))
    found = joint_temperature(recording(shown, np.full(len(T), 30.0)), T)
    assert found is not None
    # Steps and noise of a tenth are some 0.06 K: 200 samples a second leave a tenth of them within
    # the band. Its corner bends the first seconds of the exponential by RISE / TIME_CONSTANT
    # times its own time constant of under a second.
    inner = slice(int(3 * RATE), -int(3 * RATE))
    assert found[inner, 0] == pytest.approx(true[inner], abs=0.02)
    assert found[:, 0] == pytest.approx(true, abs=RISE / TIME_CONSTANT * 0.8)
    assert found[:, 1] == pytest.approx(30.0)


def test_one_thermometer_is_all_joints():
    shown, _ = warming(np.random.default_rng(1))
    found = joint_temperature(recording(shown), T)
    assert found is not None
    assert found.shape == (len(T), 2)
    assert np.array_equal(found[:, 0], found[:, 1])


def test_thermometers_that_are_nobodys_are_told_and_not_used(tmp_path):
    whole = recording(*(np.full(len(T), 20.0 + k) for k in range(3)))
    assert joint_temperature(whole, T) is None
    dataset = DataSet("arm", "test", "none", imi_scara(), "measured", recordings=(whole,))
    write_dataset(dataset, tmp_path)
    assert any("3 temperatures for 2 joints" in note for note in read_dataset(tmp_path).notes)
    own = recording(*(np.full(len(T), 20.0 + k) for k in range(2)))
    write_dataset(dataclasses.replace(dataset, recordings=(own,)), tmp_path / "own")
    assert not any("temperatures" in note for note in read_dataset(tmp_path / "own").notes)


def test_of_some_joints_only_their_own_thermometers_stay():
    two, three = (recording(*(np.full(len(T), 20.0 + k) for k in range(n))) for n in (2, 3))
    chosen = temperature_of(two, [1])
    assert chosen is not None
    assert np.all(chosen == 21.0)
    # As many as are chosen, and still nobody's.
    assert temperature_of(three, [0, 1]) is None


def test_thermometers_that_one_recording_lacks_are_told():
    whole = recording(np.full(len(T), 20.0))
    bare = dataclasses.replace(whole, name="bare", temperature=None)
    (note,) = missing_notes([whole, bare])
    assert "missing in bare" in note
    assert missing_notes([whole, whole]) == missing_notes([bare, bare]) == ()


def test_a_thermometer_that_drops_out_is_told_with_its_row(tmp_path):
    shown, _ = warming(np.random.default_rng(2))
    shown[700:720] = -1.0
    shown[720] += 2.0
    dataset = DataSet(
        "arm", "test", "none", imi_scara(), "measured", recordings=(recording(shown, shown),)
    )
    write_dataset(dataset, tmp_path)
    told = [n for n in read_dataset(tmp_path).notes if "'temperature_1'" in n]
    (leap,) = told
    # It rises farther than it fell, at sample 720, two lines further on in the file.
    assert "row 722" in leap
    assert "no joint warms so fast" in leap


def test_kelvin_are_told():
    kelvin = recording(np.full(len(T), 300.0)).temperature
    assert kelvin is not None
    (note,) = thermometer_notes(kelvin, 2, "log.csv", np.arange(len(kelvin)) + 2)
    assert "up to 300, taken for degrees Celsius" in note
    assert not list(thermometer_notes(kelvin - 273.15, 2, "log.csv", np.arange(len(kelvin)) + 2))
