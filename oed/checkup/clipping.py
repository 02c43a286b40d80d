"""Torques that were cut off where the sensor, the drive or a driver ends.

A joint that turns smoothly passes its extreme torque and leaves it: few samples share the very
largest value. Where a limiter cuts the signal, they pile up there, one equal to the next.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.checkup.finding import EvidenceRow, Finding
from oed.experiment.dataset import DataSet

# A sine has sqrt(k + 1) - 1 times as many samples in the k bins next to its extreme bin as in that one
# (arcsine law): with nine 2.2 times; a clipped signal has several times fewer.
NEIGHBOURS = 9
PILED = 3.0  # times what a sine of as many samples in the neighbours has
BIN = 1e-3  # of the range of torque, or its resolution; a pile is narrower than any noise
LEAST_SHARE = 0.002  # of the samples; a single touch is no limiter
STANDS = 1e-3  # of a joint's travel between rows: standing joints hold a torque for other reasons


def clipping_finding(dataset: DataSet) -> Finding:
    """The share of samples that pile up at a joint's largest or smallest torque."""
    names = dataset.robot.joint_names
    rows: list[EvidenceRow] = []
    clipped: list[str] = []
    for j, name in enumerate(names):
        q = [recording.q[:, j] for recording in dataset.recordings]
        tau = [recording.tau[:, j] for recording in dataset.recordings]
        for sign, end in ((1.0, "largest"), (-1.0, "smallest")):
            share = piled_share(q, [sign * column for column in tau])
            if share > LEAST_SHARE:
                value = sign * max(float((sign * column).max()) for column in tau)
                clipped.append(f"{name} ({100 * share:.2g} % at {value:.4g})")
                rows.append(
                    {"joint": name, "end": end, "torque": value, "piled up [%]": 100 * share}
                )
    if not clipped:
        return Finding("clipping", "green", "no torque piles up at its largest or smallest value")
    return Finding(
        "clipping",
        "red",
        f"torque piles up at one extreme value while the joint moves, as a limiter leaves it: "
        f"{', '.join(clipped)}; what was cut off passes for friction and for lighter links",
        "widen the range of the sensor, slow the motion down, or leave these rows out",
        tuple(rows),
    )


def piled_share(q: list[Float[ndarray, " _"]], tau: list[Float[ndarray, " _"]]) -> float:
    """Share of the samples of some recordings that lie in a pile at the largest torque.

    Args:
        q: Positions of one joint, a column each recording [rad or m].
        tau: Its torques [N m or N].

    Returns:
        0 where the samples near the extreme are as many as a smooth signal has.
    """
    joined = np.concatenate(tau)
    top, extent = float(joined.max()), float(np.ptp(joined))
    if not extent > 0:
        return 0.0
    width = max(BIN * extent, _resolution(joined))
    bins = max(1, round(NEIGHBOURS * BIN * extent / width))
    near = int(np.sum((joined <= top - width) & (joined > top - (bins + 1) * width)))
    travel = float(np.ptp(np.concatenate(q)))
    piled = 0
    for position, torque in zip(q, tau, strict=True):
        steps = np.abs(np.diff(position)) * len(position) > STANDS * travel
        moves = np.concatenate([[False], steps]) & np.concatenate([steps, [False]])
        piled += int(np.sum((torque > top - width) & moves))
    return piled / len(joined) if piled > PILED * max(near, 1) / (np.sqrt(bins + 1) - 1) else 0.0


def _resolution(tau: Float[ndarray, " samples"]) -> float:
    """Usual distance of neighbouring values: of a rounded torque its digit, else next to nothing."""
    return float(np.median(np.diff(np.unique(tau))))
