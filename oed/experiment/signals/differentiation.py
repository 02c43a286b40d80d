"""Derivatives of sampled signals: central differences, of splines, and exact for periodic motion."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import BSpline, make_interp_spline

SPLINE_DEGREE = 7


def central_difference(
    x: Float[ndarray, " samples *columns"], rate: float
) -> Float[ndarray, " samples *columns"]:
    """First derivative on a uniform grid, (x(k+1) - x(k-1)) rate / 2.

    The gain at frequency f is sin(2 pi f / rate) / (2 pi f / rate) of the true one, with no
    shift of phase. The first and last sample use one-sided differences of second order.

    Args:
        x: (N, ...) samples, N at least 3.
        rate: Sampling rate [Hz].

    Returns:
        (N, ...) derivative, unit of x per second.

    Raises:
        ValueError: If N < 3 or the rate is not positive.
    """
    if rate <= 0:
        raise ValueError(f"rate {rate:g} Hz must be positive")
    if len(x) < 3:
        raise ValueError(f"{len(x)} samples are too few to differentiate; at least 3")
    return np.gradient(x, 1 / rate, axis=0, edge_order=2)


def spline_derivative(
    x: Float[ndarray, " samples *columns"], rate: float, order: int = 1
) -> Float[ndarray, " samples *columns"]:
    """Derivative of the spline of seventh degree through all samples, with no shift of phase.

    Up to a fifth of the rate, first and second derivatives err by less than 3e-4, where central
    differences lose 24 % and, taken twice, 43 %. Noise above that is for a low-pass to remove.

    Args:
        x: (N, ...) samples on a uniform grid, N at least 8.
        rate: Sampling rate [Hz].
        order: Of the derivative, at most 6.

    Returns:
        (N, ...) derivative, unit of x per second to the power of the order.

    Raises:
        ValueError: If N < 8, the rate is not positive, or the order is not from 1 to 6.
    """
    if not 1 <= order < SPLINE_DEGREE:
        raise ValueError(f"order {order} must be from 1 to {SPLINE_DEGREE - 1}")
    return spline_through(x, rate)(np.arange(len(x)) / rate, order)


def spline_through(x: Float[ndarray, " samples *columns"], rate: float) -> BSpline:
    """The spline of `spline_derivative`, the first sample at time zero; errors likewise."""
    if rate <= 0:
        raise ValueError(f"rate {rate:g} Hz must be positive")
    if len(x) <= SPLINE_DEGREE:
        raise ValueError(f"{len(x)} samples are too few for a spline; at least {SPLINE_DEGREE + 1}")
    return make_interp_spline(np.arange(len(x)) / rate, x, k=SPLINE_DEGREE)


def spectral_derivative(
    x: Float[ndarray, " samples *columns"],
    rate: float,
    *,
    repetitions: int = 1,
    harmonics: int | None = None,
    order: int = 1,
) -> Float[ndarray, " samples *columns"]:
    """Derivative of periodic motion, exact for the harmonics kept.

    Swevers et al., "Optimal robot excitation and identification", IEEE Trans. Robotics and
    Automation 13(5), 1997: a periodic excitation is differentiated in the frequency domain.
    Everything between the harmonics of the period, and above the last one kept, is noise
    by assumption and is removed.

    Args:
        x: (N, ...) samples of exactly `repetitions` whole periods on a uniform grid, the
            sample that would open the next period left out.
        rate: Sampling rate [Hz].
        repetitions: Number of periods; content that does not repeat is dropped.
        harmonics: Highest harmonic kept; all below half the sampling rate if None.
        order: Order of the derivative; 0 only removes noise.

    Raises:
        ValueError: If N is not a multiple of `repetitions`, or too small for `harmonics`.
    """
    samples = len(x)
    _check_periods(samples, repetitions)
    # Strictly below half the rate: there the sign of a sampled sinusoid is lost.
    highest = (samples // repetitions - 1) // 2
    kept = highest if harmonics is None else harmonics
    if not 0 <= kept <= highest:
        raise ValueError(f"{kept} harmonics, but {samples // repetitions} samples carry {highest}")
    if order < 0:
        raise ValueError(f"order {order} must not be negative")
    spectrum = np.fft.rfft(x, axis=0)
    bins = np.arange(len(spectrum))
    is_kept = (bins % repetitions == 0) & (bins <= kept * repetitions)
    factor = np.where(is_kept, (2j * np.pi * rate * bins / samples) ** order, 0)
    factor = factor.reshape(-1, *(1,) * (x.ndim - 1))
    return np.fft.irfft(spectrum * factor, n=samples, axis=0)


def _check_periods(samples: int, repetitions: int) -> None:
    if repetitions < 1 or samples == 0 or samples % repetitions:
        raise ValueError(f"{samples} samples do not divide into {repetitions} whole periods")
