"""A limiter leaves a pile of equal values; a smooth torque does not, however it is rounded."""

import dataclasses

import numpy as np
import pytest

from oed.checkup.clipping import clipping_finding, piled_share
from tests.checkup.simulated_arm import dataset


def clipped(joint, level):
    def change(recording):
        tau = recording.tau.copy()
        tau[:, joint] = np.clip(tau[:, joint], -level, level)
        return dataclasses.replace(recording, tau=tau)

    return change


def test_a_clean_log_has_no_pile():
    assert clipping_finding(dataset()).level == "green"


def test_a_clipped_joint_is_named_with_value_and_share():
    clean = np.concatenate([recording.tau[:, 1] for recording in dataset().recordings])
    level = float(np.quantile(np.abs(clean), 0.95))
    found = clipping_finding(dataset(clipped(1, level)))
    assert found.level == "red"
    assert {row["joint"] for row in found.rows} == {"joint_2"}
    shares = np.array([row["piled up [%]"] for row in found.rows], dtype=float)
    assert shares.sum() == pytest.approx(5.0, abs=0.5)
    assert f"{level:.4g}" in found.text


@pytest.mark.parametrize("step", [1e-9, 0.01, 0.05])
def test_a_sine_and_its_rounding_are_not_clipped(step):
    t = np.arange(0.0, 20.0, 0.002)
    q = np.sin(2 * np.pi * 0.3 * t)
    tau = step * np.round(10 * np.cos(2 * np.pi * 0.3 * t) / step)
    assert piled_share([q], [tau]) == 0.0
    assert piled_share([q], [np.minimum(tau, 9.0)]) > 0.1


def test_a_joint_that_stands_under_load_is_not_clipped():
    t = np.arange(0.0, 10.0, 0.01)
    q = np.where(t < 5, np.sin(t), np.sin(5.0))
    tau = np.where(t < 5, 3 * np.cos(t), 4.0)
    assert piled_share([q], [tau]) == 0.0


def test_noise_does_not_hide_a_limiter():
    """It leaves the limit from row to row, and the rows at it stand alone."""
    t = np.arange(0.0, 20.0, 0.002)
    noise = np.random.default_rng(0).normal(0, 2.0, len(t))
    q, tau = np.sin(2 * np.pi * 0.3 * t), 10 * np.cos(2 * np.pi * 0.3 * t) + noise
    level = np.quantile(tau, 0.99)
    assert piled_share([q], [tau]) == 0.0
    assert piled_share([q], [np.minimum(tau, level)]) == pytest.approx(0.01, rel=0.1)


def test_a_digit_wider_than_a_bin_is_no_limiter():
    t = np.arange(0.0, 20.0, 0.002)
    q, tau = np.sin(2 * np.pi * 0.3 * t), 10 * np.cos(2 * np.pi * 0.3 * t)
    assert piled_share([q], [0.7 * np.round(tau / 0.7)]) == 0.0
