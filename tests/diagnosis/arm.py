"""Recordings of a two-joint arm for tests: its torque is worked out here, not by the estimator."""

import dataclasses
from functools import lru_cache

import numpy as np
from scipy.signal import lfilter

from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.robot.builtin import imi_scara

RATE = 500.0  # [Hz]
PERIOD = 10.0  # [s]
INERTIA = (3.923, 0.808, 0.328, 0.141)  # the paper's base parameters
COULOMB = np.array([2.61, 1.46])  # [N m]
VISCOUS = np.array([7.343, 0.787])  # [N m s/rad]
NOISE = np.array([0.5, 0.1])  # [N m]
TREMOR = 0.02  # [rad/s^2] of each wave
LENGTH = 0.359  # [m] of the first link


# Tests of many files ask for the same: it is made once, and nobody changes it.
@lru_cache(maxsize=12)
def data_set(
    seed,
    *,
    extra=None,
    repetitions=3,
    colour=0.0,
    step=0.0,
    hum=None,
    roles=None,
    near=1.0,
    shake=0.0,
    wander=0.0,
    late=0.0,
):
    """A data set with noise of a time constant `colour` [s] and encoder steps [rad].

    The motion trembles up to `shake` [Hz]. Motions for estimation reach `near` times as far as others. `extra(q, dq, ddq)` gives (N, 2) torque that the standard model does not have, `hum(t, dq)`
    what comes in its own time. In each repetition the encoders wander elsewhere, by so many rad/s^2
    for each of a few waves, and nothing else feels it. Torque is recorded `late` [s], before
    the position where that is below zero.
    """
    rng = np.random.default_rng(seed)
    roles = roles or ("estimation", "estimation", "validation", "test")
    recordings = tuple(
        _record(
            rng,
            f"{role}_{k}",
            role,
            extra=extra,
            repetitions=repetitions,
            colour=colour,
            step=step,
            hum=hum,
            shake=shake,
            wander=wander,
            late=late,
            reach=near if role == "estimation" else 1.0,
        )
        for k, role in enumerate(roles)
    )
    return DataSet("arm", "test", "none", imi_scara(), "measured", recordings=recordings)


def once(recording, rows=slice(None)):
    """Rows of a recording, without a word of repetitions."""
    t, q, tau = (getattr(recording, name)[rows] for name in ("t", "q", "tau"))
    return dataclasses.replace(recording, t=t, q=q, tau=tau, repetition=None, period=None)


def stribeck(size, speed=0.1, joint=0):
    """Hess and Soom's fall of friction from standstill."""

    def torque(q, dq, ddq):
        result = np.zeros_like(q)
        result[:, joint] = size * np.sign(dq[:, joint]) / (1 + (dq[:, joint] / speed) ** 2)
        return result

    return torque


def _record(rng, name, role, *, extra, repetitions, colour, step, hum, shake, reach, wander, late):
    t = np.arange(int(PERIOD * RATE) * repetitions) / RATE
    coefficients = rng.normal(size=(2, 2, 5)) / np.sqrt(np.arange(1, 6))
    q, dq, ddq = (reach * x for x in _motion(coefficients, t))
    if shake > 0:
        q, dq, ddq = (x + y for x, y in zip((q, dq, ddq), _tremor(t, shake), strict=True))
    measured = q
    if late != 0:
        q, dq, ddq = (reach * x for x in _motion(coefficients, t, late))
    tau = rigid(q, dq, ddq) + COULOMB * np.sign(dq) + VISCOUS * dq
    if extra is not None:
        tau = tau + extra(q, dq, ddq)
    if hum is not None:
        tau = tau + hum(t + rng.uniform(0, PERIOD), dq)
    tau = tau + NOISE * _noise(rng, len(t), colour)
    measured = measured + 1e-5 * rng.normal(size=q.shape)
    if wander > 0:
        measured = measured + wander * _wandering(rng, t)
    if step > 0:
        measured = np.round(q / step) * step
    return Recording(
        name,
        role,
        t,
        measured,
        tau,
        repetition=np.repeat(np.arange(repetitions), int(PERIOD * RATE)),
        period=PERIOD,
    )


def _motion(coefficients, t, late=0.0):
    columns = []
    for a, b in coefficients:
        largest = (np.abs(x).max() for x in _series(a, b, t))
        size = min(limit / x for limit, x in zip((1.4, 7, 4.8), largest, strict=True))
        columns.append([x * size for x in _series(a, b, t - late)])
    return tuple(np.stack(column, axis=1) for column in zip(*columns, strict=True))


def _series(a, b, t):
    orders = np.arange(1, 6) * 2 * np.pi / PERIOD
    s, c = np.sin(np.outer(t, orders)), np.cos(np.outer(t, orders))
    q, dq = s @ a + c @ b, (c * orders) @ a - (s * orders) @ b
    return q, dq, -(s * orders**2) @ a - (c * orders**2) @ b


def _wandering(rng, t):
    """Waves of 2 to 12 Hz, their phases drawn anew in each repetition."""
    turn = (t // PERIOD).astype(int)
    total = np.zeros((len(t), 2))
    for w in 2 * np.pi * np.arange(2.0, 12.0, 0.7):
        phase = rng.uniform(0, 2 * np.pi, (turn[-1] + 1, 2))[turn]
        total += np.sin(w * t[:, None] + phase) / w**2
    return total


def _tremor(t, highest):
    """Small waves of all frequencies up to the highest, as a stiff drive makes them."""
    q, dq, ddq = (np.zeros((len(t), 2)) for _ in range(3))
    for k in range(10, round(highest * PERIOD)):
        w = 2 * np.pi * k / PERIOD
        size, phase = TREMOR / w**2, np.array([k**2, 1.7 * k**2])
        wave, slope = np.sin(w * t[:, None] + phase), np.cos(w * t[:, None] + phase)
        q, dq, ddq = q + size * wave, dq + size * w * slope, ddq - size * w**2 * wave
    return q, dq, ddq


def rigid(q, dq, ddq, inertia=INERTIA):
    """Torque of the rigid arm [N m]."""
    total, x, y, second = inertia
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    both = 2 * ddq[:, 0] + ddq[:, 1]
    coriolis = dq[:, 1] * (2 * dq[:, 0] + dq[:, 1])
    spin = second * (ddq[:, 0] + ddq[:, 1])
    first = total * ddq[:, 0] + spin
    first += LENGTH * (x * (c * both - s * coriolis) - y * (s * both + c * coriolis))
    last = LENGTH * (x * (c * ddq[:, 0] + s * dq[:, 0] ** 2))
    last += LENGTH * (y * (c * dq[:, 0] ** 2 - s * ddq[:, 0])) + spin
    return np.stack([first, last], axis=1)


def _noise(rng, count, colour):
    white = rng.normal(size=(count, 2))
    if colour <= 0:
        return white
    pole = np.exp(-1 / (RATE * colour))
    return lfilter([np.sqrt(1 - pole**2)], [1, -pole], white, axis=0)
