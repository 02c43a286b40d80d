"""From recordings to one fine grid and one analysis band: the only way from a log to an estimate."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion, follow_one_another
from oed.experiment.preparation.band import Band
from oed.experiment.preparation.encoder_steps import (
    encoder_steps,
    repeated_steps,
    rounding_deviation,
)
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.preparation.settings import ProcessingSettings, choose_settings, period_of
from oed.experiment.preparation.uniform import recorded, uniform
from oed.experiment.recording import Recording
from oed.experiment.temperature import has_thermometers, joint_temperature

LEAST_ROWS = 20  # of a recording that is of use


def prepare(
    recordings: Sequence[Recording], settings: ProcessingSettings | None = None
) -> tuple[Prepared, ...]:
    """Bring all recordings to one fine grid and one band.

    Args:
        recordings: Of one data set.
        settings: How; chosen from the recordings' positions if None.

    Raises:
        ValueError: If a recording, or what pauses leave of it, is too short for its band, or has no
            logged velocity where that is asked for.
    """
    settings = settings or choose_settings(recordings)
    starts = _starts_end_to_end(recordings) or [None] * len(recordings)
    warmth = all(map(has_thermometers, recordings))
    return tuple(
        _prepare_one(recording, settings, start=start, warmth=warmth)
        for recording, start in zip(recordings, starts, strict=True)
    )


def _starts_end_to_end(recordings: Sequence[Recording]) -> list[float] | None:
    """When each recording starts if it follows the one before [s]; None where one clock timed all."""
    if follow_one_another([r.t for r in recordings]):
        return None
    lengths = [r.duration + float(np.median(np.diff(r.t))) for r in recordings]
    return [0.0, *accumulate(lengths[:-1])]


def _velocity_noise(density: Float[ndarray, " joints"], band: Band) -> Float[ndarray, " joints"]:
    """Standard deviation of the smoothed, differentiated encoder noise [rad/s]."""
    frequency = np.linspace(0, band.rate / 2, 2000)
    gain = 1 / (1 + (frequency / band.smoothing) ** 8)
    power = np.trapezoid((2 * np.pi * frequency * gain) ** 2, frequency)
    return np.sqrt(density * power)


def _prepare_one(
    recording: Recording, settings: ProcessingSettings, *, start: float | None, warmth: bool
) -> Prepared:
    band, noise = settings.band, settings.noise
    signals = uniform(recording, band.logged_rate)
    smooth, dq, ddq = band.differentiate(signals.q)
    if settings.velocity == "logged":
        if signals.dq is None:
            raise ValueError(f"{recording.name}: no dq was logged; differentiate the position")
        dq, ddq = band.differentiate_velocity(signals.dq)
    t, tau = signals.t[:: band.logged], band.thin(signals.tau)
    if band.rows(len(t) - 2 * band.cut) < LEAST_ROWS:
        raise ValueError(
            f"{recording.source or recording.name}: {recording.duration:g} s are too short for a "
            f"band of {band.cutoff:.3g} Hz; leave it out of the data set, or record longer"
        )
    inner = slice(band.cut, len(t) - band.cut)
    rounding = rounding_deviation(encoder_steps([recording]))
    shift = 0.0 if start is None else start - float(recording.t[0])
    rows_t = band.instants(t[inner])
    prepared = Prepared(
        name=recording.name,
        role=recording.role,
        motion=Motion(
            t + shift,
            smooth,
            dq,
            ddq,
            averaged=True,
            noise=tuple(noise.density.tolist()),
            temperature=joint_temperature(recording, t) if warmth else None,
        )[inner],
        fine_torque=tau[inner],
        torque=band.apply(tau[inner]),
        t=rows_t,
        band=band,
        repetition=_repetition(recording, rows_t),
        period=period_of(recording),
        # Rounding of slow motion is not white: where the noise is read off there is less of it.
        position_noise=np.maximum(np.sqrt(noise.density * band.logged_rate / 2), rounding),
        repeated_steps=repeated_steps([recording]),
        sign_noise=_velocity_noise(noise.density, band),
        recorded=recorded(recording, t[inner], band.logged_rate, band.edge),
        laid=start is not None,
    )
    if prepared.valid.sum() < LEAST_ROWS:
        raise ValueError(
            f"{recording.source or recording.name}: between its pauses no stretch is long enough for a "
            f"band of {band.cutoff:.3g} Hz; leave it out of the data set, or record without pauses"
        )
    return prepared


def _repetition(recording: Recording, instants: Float[ndarray, " rows"]) -> Int[ndarray, " rows"]:
    if recording.repetition is None or recording.repetitions < 2:
        return np.full(len(instants), -1)
    before = np.searchsorted(recording.t, instants + 1e-9, side="right") - 1
    return recording.repetition[before]
