"""Noise that a model makes of the motion, and what is left of it where the torque is late.

Encoders err, and what shakes the arm moves it: a model makes torque of both. One that passes it
through a filter leaves less of it, whatever the arm does, and one that moves it in time makes it
meet the noise of the torque otherwise. So much of what a lag explains says nothing of the arm.
What repetitions differ by shows both noises and how they go together; what comes again in each,
and a motion that was run once, show only what encoders are known to err.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float
from numpy import ndarray

from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.delay import Late
from oed.dynamics.effects.effect import Effect, with_columns
from oed.dynamics.effects.friction import Viscous
from oed.dynamics.effects.motor import RotorInertia
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.torque_change import TorqueChange
from oed.experiment.preparation.encoder_steps import Torque, encoder_torque, rounding_deviation

SMOOTH = (Viscous, RotorInertia)


@dataclass(frozen=True)
class MotionNoise:
    """Spectra of the white noise that one recording's motion brings in.

    Attributes:
        frequency: (F,) [Hz].
        power: (F, n) of the modelled torque's noise; the sum over F is that of white squares.
        shared: (F, n) of it with that of the measured torque.
    """

    frequency: Float[ndarray, " frequencies"]
    power: Float[ndarray, "frequencies joints"]
    shared: Complex[ndarray, "frequencies joints"]

    def calmed(self, late: Late) -> Float[ndarray, " joints"]:
        """(n,) white squares that go where the modelled torque is late; negative if more come."""
        passed = late.response(self.frequency)[:, None]
        kept = (1 - np.abs(passed) ** 2) * self.power
        return np.sum(kept - 2 * np.real((1 - passed) * self.shared), axis=0)


def calmed(effect: Effect, rows: Rows) -> Float[ndarray, " joints"]:
    """(n,) white squares of noise alone that a late torque takes away; 0 of all other effects."""
    if not (isinstance(effect, TorqueChange) and isinstance(effect.measurement, Late)):
        return np.zeros(rows.weights.shape[1])
    late = effect.measurement
    return sum(
        (noise.calmed(late) for noise in motion_noise(rows, effect.reference)),
        np.zeros(rows.weights.shape[1]),
    )


def motion_noise(rows: Rows, reference: ReferenceTorque) -> tuple[MotionNoise, ...]:
    """Of every recording, remembered with the rows.

    Args:
        rows: Recordings, or their mean repetitions.
        reference: The torque as modelled.
    """
    return rows.remembered.get((reference,), lambda: tuple(_of_each(rows, reference)))


def _smooth(reference: ReferenceTorque) -> ReferenceTorque:
    """The part that grows with acceleration and speed."""
    kept, values = [], []
    for effect, place in with_columns(reference.others):
        if isinstance(effect, SMOOTH):
            kept.append(effect)
            values += reference.coefficients[place]
    return ReferenceTorque(reference.robot, tuple(kept), tuple(values))


def _of_each(rows: Rows, reference: ReferenceTorque) -> Iterator[MotionNoise]:
    # Motions of single repetitions are not seen again.
    whole, smooth = _torque_of(dataclasses.replace(reference)), _torque_of(_smooth(reference))
    for k, p in enumerate(rows.prepared):
        own = rows.alone(k, p)
        deviations = rounding_deviation(p.repeated_steps) if p.singles else p.position_noise
        # Errors are drawn that may turn a joint round where it hardly moves: these rows tell less.
        (encoders,) = encoder_torque(smooth, [p], [deviations])
        (felt,) = _spectra(own, [encoders])
        frequency = np.fft.rfftfreq(p.rows, 1 / p.band.analysis_rate)
        power, shared = np.abs(felt) ** 2, np.zeros_like(felt)
        if p.singles:
            measured, modelled = (
                _spectra(own, _differences(each))
                for each in (
                    [s.torque for s in p.singles],
                    [s.band.apply(whole(s.motion)) for s in p.singles],
                )
            )
            # Over M - 1 for one repetition, over M more for the mean.
            count = len(p.singles)
            share = 1 / (count - 1) / count
            power = power + share * np.sum(np.abs(modelled) ** 2, axis=0)
            shared = share * np.sum(modelled * np.conj(measured), axis=0)
        yield MotionNoise(frequency, power, shared)


def _torque_of(reference: ReferenceTorque) -> Torque:
    return lambda motion: reference.parts(motion).sum(axis=2)


def _differences(
    each: Sequence[Float[ndarray, "rows joints"]],
) -> list[Float[ndarray, "rows joints"]]:
    mean = np.mean(each, axis=0)
    return [one - mean for one in each]


def _spectra(
    rows: Rows, signals: Sequence[Float[ndarray, "rows joints"]]
) -> Complex[ndarray, "signals frequencies joints"]:
    """Of white signals on one recording's rows, each with the sum of its squares."""
    joints = range(rows.weights.shape[1])
    white = np.stack(
        [np.concatenate([rows.whiten([s[:, [j]]], j) for j in joints], axis=1) for s in signals]
    )
    count = white.shape[1]
    twice = np.full(count // 2 + 1, 2.0)
    twice[0] = 1.0
    if count % 2 == 0:
        twice[-1] = 1.0
    return np.fft.rfft(white, axis=1) * np.sqrt(twice / count)[:, None]
