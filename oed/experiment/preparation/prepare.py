"""From recordings to one fine grid and one analysis band, chosen from their positions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion, follow_one_another
from oed.experiment.choose_settings import search_cutoff
from oed.experiment.preparation.band import EDGE, Band, PositionNoise, choose_band, position_noise
from oed.experiment.preparation.bridge import bridged
from oed.experiment.preparation.encoder_steps import (
    encoder_steps,
    repeated_steps,
    rounding_deviation,
)
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.processing import fresh_samples
from oed.experiment.recording import Recording
from oed.experiment.signals.gaps import find_gaps
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.resampling import resample, uniform_grid
from oed.experiment.temperature import has_thermometers, joint_temperature

FINEST_RATE = 1000.0  # [Hz] of the fine grid; arms and encoders give nothing beyond
LEAST_BAND = 8.0  # [Hz] in which friction's steps at reversals are still seen
HIGHEST_BAND = 30.0  # [Hz] beyond which gears ring and no rigid arm is left to identify
SHORTEST_WAVE = 260.0  # [1/turn] of a torque ripple and its first overtone
LEAST_ROWS = 20  # of a recording that is of use
LEAST_STRETCH = 1.0  # [s] between gaps for a spectrum of the position


def _fine_rate(recordings: tuple[Recording, ...]) -> float:
    """Common rate of the fine grid [Hz]: the slowest recording's, rounded, at most 1 kHz."""
    slowest = min(1 / float(np.median(np.diff(r.t))) for r in recordings)
    return min(FINEST_RATE, float(f"{slowest:.3g}"))


def prepare(recordings: tuple[Recording, ...]) -> tuple[Prepared, ...]:
    """Bring all recordings to one fine grid and one band, chosen from their positions.

    Of a test recording only the times count, or it would have a say in what is found.

    Raises:
        ValueError: If a recording, or what pauses leave of it, is too short for its band.
    """
    rate = _fine_rate(recordings)
    raw = [_uniform(recording, rate) for recording in recordings]
    positions = [
        stretch
        for recording, (t, q, _) in zip(recordings, raw, strict=True)
        if recording.role != "test"
        for stretch in _stretches(q, _recorded(recording, t, rate), rate)
    ]
    highest = HIGHEST_BAND
    if all(r.repetitions < 2 for r in recordings if r.role == "estimation"):
        highest = min(highest, _motion_band(recordings, rate))
    noise = position_noise(positions, rate)
    band = choose_band(noise, rate, LEAST_BAND, highest)
    periods = [p for p in map(_period, recordings) if p is not None]
    band = band.thinned(_fastest_wave(band, positions), periods)
    starts = _starts_end_to_end(recordings)
    warmth = all(map(has_thermometers, recordings))
    return tuple(
        _prepare_one(recording, *signals, band=band, noise=noise, start=start, warmth=warmth)
        for recording, signals, start in zip(
            recordings, raw, starts or [None] * len(raw), strict=True
        )
    )


def _fastest_wave(band: Band, positions: Sequence[Float[ndarray, "_ joints"]]) -> float:
    """Frequency at which the shortest wave of position that has a name is crossed [Hz]."""
    speed = max(float(np.abs(band.differentiate(q)[1]).max()) for q in positions)
    return SHORTEST_WAVE * speed / (2 * np.pi)


def _starts_end_to_end(recordings: tuple[Recording, ...]) -> list[float] | None:
    """When each recording starts if it follows the one before [s]; None where one clock timed all."""
    if follow_one_another([r.t for r in recordings]):
        return None
    lengths = [r.duration + float(np.median(np.diff(r.t))) for r in recordings]
    return [0.0, *accumulate(lengths[:-1])]


def _motion_band(recordings: tuple[Recording, ...], rate: float) -> float:
    """Twice the frequency below which motion lies [Hz], at least `LEAST_BAND`.

    Without repetitions nothing tells noise from what drives and loops add above the motion.
    """
    estimation = tuple(r for r in recordings if r.role == "estimation")
    shortest = min(recording.duration for recording in recordings)
    return max(LEAST_BAND, 2 * search_cutoff(estimation, rate, shortest).band_edge)


def _velocity_noise(density: Float[ndarray, " joints"], band: Band) -> Float[ndarray, " joints"]:
    """Standard deviation of the smoothed, differentiated encoder noise [rad/s]."""
    frequency = np.linspace(0, band.rate / 2, 2000)
    gain = 1 / (1 + (frequency / band.smoothing) ** 8)
    power = np.trapezoid((2 * np.pi * frequency * gain) ** 2, frequency)
    return np.sqrt(density * power)


def _uniform(
    recording: Recording, rate: float
) -> tuple[
    Float[ndarray, " samples"], Float[ndarray, "samples joints"], Float[ndarray, "samples joints"]
]:
    fresh = fresh_samples(recording)
    logged = 1 / float(np.median(np.diff(recording.t)))
    t, q, tau = recording.t[fresh], recording.q[fresh], recording.tau[fresh]
    # Whole steps by averaging first: interpolation alone would fold high noise into the band.
    step = round(logged / rate)
    if step > 1:
        dense = uniform_grid(t, rate * step)
        q, tau = (
            lowpass(x, rate * step, 0.4 * rate)
            for x in (
                bridged(t, q, dense, rate),
                resample(t, tau, dense, "linear"),
            )
        )
        return dense[::step], q[::step], tau[::step]
    grid = uniform_grid(t, rate)
    return grid, bridged(t, q, grid, rate), resample(t, tau, grid, "linear")


def _prepare_one(
    recording: Recording,
    t: Float[ndarray, " logged"],
    q: Float[ndarray, "logged joints"],
    tau: Float[ndarray, "logged joints"],
    *,
    band: Band,
    noise: PositionNoise,
    start: float | None,
    warmth: bool,
) -> Prepared:
    smooth, dq, ddq = band.differentiate(q)
    t, tau = t[:: band.logged], band.thin(tau)
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
        period=_period(recording),
        # Rounding of slow motion is not white: where the noise is read off there is less of it.
        position_noise=np.maximum(np.sqrt(noise.density * band.logged_rate / 2), rounding),
        repeated_steps=repeated_steps([recording]),
        sign_noise=_velocity_noise(noise.density, band),
        recorded=_recorded(recording, t[inner], band.logged_rate, band.edge),
        laid=start is not None,
    )
    if prepared.valid.sum() < LEAST_ROWS:
        raise ValueError(
            f"{recording.source or recording.name}: between its pauses no stretch is long enough for a "
            f"band of {band.cutoff:.3g} Hz; leave it out of the data set, or record without pauses"
        )
    return prepared


def _recorded(
    recording: Recording, t: Float[ndarray, " samples"], rate: float, edge: float = EDGE
) -> Bool[ndarray, " samples"]:
    """False in gaps of the log, such as between runs, and where smoothing feels them."""
    recorded = np.ones(len(t), dtype=bool)
    for k in find_gaps(recording.t, rate):
        before, after = recording.t[k], recording.t[k + 1]
        recorded &= (t < before - edge) | (t > after + edge)
    return recorded


def _repetition(recording: Recording, instants: Float[ndarray, " rows"]) -> Int[ndarray, " rows"]:
    if recording.repetition is None or recording.repetitions < 2:
        return np.full(len(instants), -1)
    before = np.searchsorted(recording.t, instants + 1e-9, side="right") - 1
    return recording.repetition[before]


def _stretches(
    q: Float[ndarray, "samples joints"], recorded: Bool[ndarray, " samples"], rate: float
) -> list[Float[ndarray, "_ joints"]]:
    """Positions between gaps of the log: the leap across a gap would pass for fast motion."""
    edges = np.flatnonzero(np.diff(recorded, prepend=False, append=False))
    stretches = [q[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True)]
    longest = max((len(s) for s in stretches), default=0)
    # Short stretches tell little of slow motion, and would shorten the spectra of all.
    return [s for s in stretches if len(s) >= max(longest / 2, LEAST_STRETCH * rate)] or [q]


def _period(recording: Recording) -> float | None:
    if recording.repetition is None or recording.repetitions < 2:
        return None
    if recording.period is not None:
        return recording.period
    _, first = np.unique(recording.repetition, return_index=True)
    return float(np.median(np.diff(recording.t[np.sort(first)])))
