"""Disturbances that come and go in their own time, and act with the state of the arm.

A brake that drags now and then, a field that pulls on a rotor's poles: what repetitions of one
motion differ by is a carrier, such as the direction of a joint, times something slow or something
that turns at a frequency of its own. Noise knows nothing of the carrier. Multiplied by the carrier
of another time within the period it has the same spectrum, whatever its colour, so that carriers
moved in time show what noise would gather (surrogate data: Theiler et al. 1992, Physica D 58, 77-94).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.differing import PADDING, Differing

SHIFTS = 40  # of the carrier
MIDDLE = (0.08, 0.92)  # of the period: nearer to a whole one a moved carrier is still itself
DEVIATIONS = 5.0  # of what moved carriers gather, beyond their mean
LEAST_SHARE = 0.1  # of the variance between repetitions, beyond what moved carriers gather
POWERS = 4  # of a position, from 0 on


@dataclass(frozen=True)
class Modulation:
    """Something of one joint's torque that is not the same at every repetition.

    Attributes:
        joint: Index.
        depends_on: "time" and the coordinate that carries it.
        share: Of the variance between repetitions, beyond what noise would gather.
        label: In words.
    """

    joint: int
    depends_on: tuple[str, str]
    share: float
    label: str


def find_modulations(recordings: Sequence[Differing], rate: float) -> tuple[Modulation, ...]:
    """The clearest modulation of every joint that has one, by its own direction or position.

    Args:
        recordings: Of repeated motions.
        rate: [Hz].
    """
    joints = range(recordings[0].torque.shape[1] if recordings else 0)
    carried = [_carried(recordings, joint, rate) for joint in joints]
    return tuple(max(found, key=lambda m: m.share) for found in carried if found)


def _carried(recordings: Sequence[Differing], joint: int, rate: float) -> list[Modulation]:
    """What comes and goes with a joint's direction, and what turns while its position matters."""
    whole = sum(float(np.sum(r.torque[:, joint] ** 2)) for r in recordings)

    def share_beyond(gather: Callable[[float], float]) -> float:
        """Of the carrier in its place beyond moved ones; zero if noise might gather it, too."""
        moved = np.array([gather(x) for x in np.linspace(*MIDDLE, SHIFTS)]) / max(whole, 1e-300)
        beyond = gather(0.0) / max(whole, 1e-300) - moved.mean()
        return float(beyond) if beyond > max(DEVIATIONS * moved.std(), LEAST_SHARE) else 0.0

    number, found = joint + 1, []
    slow = share_beyond(lambda part: _slow(recordings, joint, part))
    if slow > 0:
        label = f"friction along sgn(dq_{number}) that comes and goes"
        found.append(Modulation(joint, ("time", f"dq_{number}"), slow, label))
    line = share_beyond(lambda part: float(_turning(recordings, joint, part).max()))
    if line > 0:
        power = _turning(recordings, joint, part=0.0)
        frequency = 0.5 * rate * np.argmax(power) / (len(power) - 1)
        label = f"sin(2 pi {frequency:.3g} t + phase) f(q_{number})"
        found.append(Modulation(joint, ("time", f"q_{number}"), line, label))
    return found


def _slow(recordings: Sequence[Differing], joint: int, part: float) -> float:
    """Squares of torque times direction that vary more slowly than the direction does.

    Args:
        recordings: Of repeated motions.
        joint: Whose torque and direction.
        part: Of the period by which the direction is moved.
    """
    gathered = 0.0
    for r in recordings:
        direction = r.direction[:, joint]
        turns = np.count_nonzero(np.diff(np.sign(direction)))
        product = r.torque[:, joint] * np.roll(direction, round(part * r.period))
        power = np.abs(np.fft.rfft(product)) ** 2
        gathered += 2 * float(np.sum(power[1 : max(turns // 2, 2)])) / len(product)
    return gathered


def _turning(
    recordings: Sequence[Differing], joint: int, part: float
) -> Float[ndarray, " frequencies"]:
    """Squares at each frequency of torque times smooth shapes of the position.

    Args:
        recordings: Of repeated motions.
        joint: Whose torque and position.
        part: Of the period by which the position is moved.
    """
    length = PADDING * max(len(r.torque) for r in recordings)
    power = np.zeros(length // 2 + 1)
    for r in recordings:
        q = np.roll(r.position[:, joint], round(part * r.period))
        even = (q - q.mean()) / max(float(q.std()), 1e-12)
        shapes = np.linalg.qr(np.vander(even, POWERS, increasing=True))[0]
        product = r.torque[:, [joint]] * shapes
        power += 2 * np.sum(np.abs(np.fft.rfft(product, length, axis=0)) ** 2, axis=1)
    return power
