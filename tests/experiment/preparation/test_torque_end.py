"""Where a torque was filtered before it was logged, and that the band ends there."""

import dataclasses

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from oed.experiment.preparation.settings import LEAST_BAND, choose_settings
from oed.experiment.preparation.torque_end import torque_end
from oed.experiment.recording import Recording

RATE = 200.0


def recorded(filtered_at=None):
    """A slow joint with dry friction and a sensor's noise."""
    rng = np.random.default_rng(1)
    t = np.arange(0, 30, 1 / RATE)
    w = 2 * np.pi * 0.3
    q = np.stack([np.sin(w * t) + 0.3 * np.sin(3.3 * w * t), np.cos(w * t)], axis=1)
    dq = np.gradient(q, 1 / RATE, axis=0)
    tau = 5 * np.cos(q) + np.sign(dq) + 0.05 * rng.normal(size=q.shape)
    if filtered_at is not None:
        tau = sosfiltfilt(butter(8, filtered_at, fs=RATE, output="sos"), tau, axis=0)
    return Recording("a", "estimation", t, q + 1e-6 * rng.normal(size=q.shape), tau)


def test_noise_and_friction_reach_to_the_end_of_the_band():
    assert torque_end([recorded().tau], RATE) > 0.4 * RATE
    assert choose_settings((recorded(),)).cutoff >= LEAST_BAND


@pytest.mark.parametrize("filtered_at", [1.5, 2.0])
def test_the_band_passes_what_a_filter_left_and_no_more(filtered_at):
    own = recorded(filtered_at)
    end = torque_end([own.tau], RATE)
    assert filtered_at < end < 2 * filtered_at
    settings = choose_settings((own,))
    assert end < settings.cutoff <= 2 * end
    assert any("filtered before it was logged" in reason for reason in settings.reasons)
    assert settings.filtered_at == end
    assert choose_settings((recorded(),)).filtered_at is None
    # Units do not matter, nor the joint that has least.
    scaled = dataclasses.replace(own, tau=own.tau * [1000.0, 1e-3])
    assert torque_end([scaled.tau], RATE) == pytest.approx(end)
