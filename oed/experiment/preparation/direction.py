"""Where no log tells the direction of motion, and what that does to the torque.

Dry friction steps by twice its height where a joint turns, and takes any value in between while
the joint sticks. The velocity there is known only to the encoder's noise and to the ripple with
which smoothing answers the kink of a joint that stops. No model predicts these rows better than
that, so they must neither judge one nor pass for noise.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import binary_opening, maximum_filter1d, minimum_filter1d
from scipy.signal import fftconvolve

from oed.experiment.preparation.prepared import Prepared

SIGMAS = 2.0  # velocities below this many standard deviations have no direction
# Largest ripple of a smoothed velocity beside a kink, in units of the leap of the acceleration
# over the smoothing's cut-off.
RIPPLE = 0.1
# Share of a recording's typical velocity, and the time that a joint spends below it [s], from
# which on it lingers: friction builds up over a distance, which it has not covered.
SLOW = 0.02
LINGERING = 0.1
HARMFUL = 0.3  # share of the noise at which an uncertain direction spoils its estimate


def uncertain_direction(recording: Prepared, joint: int) -> Bool[ndarray, " samples"]:
    """Fine samples at which a joint may move either way, or not at all."""
    velocity = recording.motion.dq[:, joint]
    lingers = _lasting(hardly_moves(recording, joint), recording)
    uncertain = _slower_than_noise(recording, joint) | lingers
    # The crossing itself lies somewhere between two samples.
    turns = np.flatnonzero(np.signbit(velocity[1:]) != np.signbit(velocity[:-1]))
    uncertain[turns] = uncertain[turns + 1] = True
    return uncertain


def hardly_moves(recording: Prepared, joint: int) -> Bool[ndarray, " samples"]:
    """Fine samples at which a joint is slow for that recording."""
    velocity = recording.motion.dq[:, joint]
    return np.abs(velocity) < SLOW * np.sqrt(np.mean(velocity**2))


def stopped(recording: Prepared, joint: int) -> Bool[ndarray, " samples"]:
    """Fine samples at which a joint rests, as far as its encoder can tell; not where it turns."""
    return _lasting(_slower_than_noise(recording, joint), recording)


def _slower_than_noise(recording: Prepared, joint: int) -> Bool[ndarray, " samples"]:
    band, motion = recording.band, recording.motion
    acceleration = motion.ddq[:, joint]
    reach = 2 * int(np.ceil(band.rate / band.smoothing)) + 1
    leap = maximum_filter1d(acceleration, reach) - minimum_filter1d(acceleration, reach)
    sigma = np.hypot(recording.sign_noise[joint], RIPPLE * leap / band.smoothing)
    return np.abs(motion.dq[:, joint]) < SIGMAS * np.maximum(sigma, 1e-12)


def _lasting(slow: Bool[ndarray, " samples"], recording: Prepared) -> Bool[ndarray, " samples"]:
    """Only the stretches that last."""
    least = int(np.ceil(LINGERING * recording.band.rate))
    return binary_opening(slow, np.ones(least)).astype(bool)


def direction_error(
    recording: Prepared, joint: int, coulomb: float
) -> Float[ndarray, " settled_samples"]:
    """Standard deviation of the filtered torque for want of a direction [N m].

    Friction anywhere between its two values, alike within one uncertain stretch.

    Args:
        recording: On its fine grid.
        joint: Index.
        coulomb: Height of the friction step, one side [N m].
    """
    spread = uncertain_direction(recording, joint) * (abs(coulomb) / np.sqrt(3))
    return np.abs(fftconvolve(spread, recording.band.taps, mode="valid"))


def trusted_samples(
    recording: Prepared, joint: int, coulomb: float, deviation: float
) -> Bool[ndarray, " settled_samples"]:
    """Settled fine samples whose filtered torque shows noise rather than an uncertain direction.

    Args:
        recording: On its fine grid.
        joint: Index.
        coulomb: Height of the friction step [N m].
        deviation: Standard deviation of the noise in the band [N m].
    """
    missing = fftconvolve(~recording.recorded * 1.0, np.ones(len(recording.band.taps)), "valid")
    harmless = direction_error(recording, joint, coulomb) < HARMFUL * deviation
    return harmless & (missing < 0.5)


def certainty(
    recording: Prepared, coulomb: Float[ndarray, " joints"], deviation: Float[ndarray, " joints"]
) -> Float[ndarray, "valid_rows joints"]:
    """Weights from 0 to 1 of the valid rows' errors: the share of noise in their deviation."""
    spread = np.stack(
        [direction_error(recording, j, float(c)) for j, c in enumerate(coulomb)], axis=1
    )[:: recording.band.factor]
    noise = np.maximum(deviation, np.finfo(float).tiny)
    weights = noise / np.hypot(noise, spread)
    return weights[recording.valid]


def reversal_shapes(recording: Prepared, joint: int) -> Float[ndarray, "samples 2"]:
    """An impulse and a narrow odd bump at each reversal, on the fine grid."""
    band, velocity = recording.band, recording.motion.dq[:, joint]
    turns = np.flatnonzero(np.signbit(velocity[1:]) != np.signbit(velocity[:-1]))
    sigma = max(float(recording.sign_noise[joint]), 1e-12)
    impulses = np.zeros(len(velocity))
    impulses[turns] = np.sign(velocity[turns + 1] - velocity[turns])
    slope = np.abs(velocity[turns + 1] - velocity[turns]) * band.rate
    typical = float(np.median(slope)) if len(turns) else 0.0
    width = max(3 * sigma, RIPPLE * typical / band.smoothing)
    bump = np.sign(velocity) * np.exp(-np.abs(velocity) / width)
    return np.stack([impulses, bump], axis=1)
