"""The paper's two-link regressor (16) on random harmonic motion, written out for the tests."""

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

JOINTS = 2
NAMES = ("Izz_1", "mx_2", "my_2", "Izz_2", "Fc_1", "Fv_1", "Fc_2", "Fv_2")
UNITS = ("kg m^2", "kg m", "kg m", "kg m^2", "N m", "N m s/rad", "N m", "N m s/rad")
TRUTH = np.array([3.923, 0.808, 0.328, 0.141, 2.61, 7.343, 1.460, 0.787])
DEVIATIONS = np.array([1.2, 0.3])  # [N m] of the simulated torque noise


def planar_regressor(rng, samples, horizon=10.0):
    t = np.arange(samples) * horizon / samples
    amplitude = rng.uniform(-0.5, 0.5, (2, 3, 1))
    omega = rng.uniform(0.3, 1.825, (2, 3, 1))
    q = np.sum(amplitude * np.sin(omega * t), axis=1)
    d1, d2 = np.sum(amplitude * omega * np.cos(omega * t), axis=1)
    a1, a2 = np.sum(-amplitude * omega**2 * np.sin(omega * t), axis=1)
    s, c, z = 0.359 * np.sin(q[1]), 0.359 * np.cos(q[1]), np.zeros(samples)
    both, coriolis = 2 * a1 + a2, d2 * (2 * d1 + d2)
    first = [a1, c * both - s * coriolis, -s * both - c * coriolis, a1 + a2, np.sign(d1), d1, z, z]
    second = [z, c * a1 + s * d1**2, -s * a1 + c * d1**2, a1 + a2, z, z, np.sign(d2), d2]
    return np.stack([np.stack(first, 1), np.stack(second, 1)], axis=1).reshape(2 * samples, 8)


def white_noise(rng, samples):
    return rng.standard_normal((samples, JOINTS))


def autoregressive_noise(rng, samples, coefficient):
    """Unit variance AR(1), stationary from the first sample."""
    innovation = rng.standard_normal((samples + 1000, JOINTS))
    scale = np.sqrt(1 - coefficient**2)
    return np.asarray(lfilter([scale], [1.0, -coefficient], innovation, axis=0))[1000:]


def low_passed_noise(rng, samples, cutoff):
    """White noise through a Butterworth filter, cut-off as a share of the Nyquist frequency."""
    innovation = rng.standard_normal((samples + 1000, JOINTS))
    return sosfilt(butter(4, cutoff, output="sos"), innovation, axis=0)[1000:] / np.sqrt(cutoff)


def torque(regressor, noise):
    return regressor @ TRUTH + (DEVIATIONS * noise).reshape(-1)
