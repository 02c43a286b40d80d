"""Where the joints went in each role: against the robot's limits, and against one another."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.checkup.finding import EvidenceRow, Finding
from oed.experiment.dataset import DataSet
from oed.experiment.recording import HELD_OUT, ROLES, Recording

BEYOND = 0.02  # of the range, by which a position may be beyond its limit: rounding, calibration
FAR = 2.0  # times the travel for estimation, that a held-out recording may have
NARROW = 0.1  # of the position range: what a joint shows of gravity within it is nearly a constant


def range_finding(dataset: DataSet) -> Finding:
    """Positions against the limits of the robot's file."""
    limits = dataset.robot.limits.position
    spans = _spans(dataset.recordings)
    width = limits[:, 1] - limits[:, 0]
    finite = np.isfinite(width)
    margin = np.where(finite, BEYOND * np.where(finite, width, 1.0), np.inf)
    outside = (spans[:, 0] < limits[:, 0] - margin) | (spans[:, 1] > limits[:, 1] + margin)
    names = dataset.robot.joint_names
    rows = tuple(
        {
            "joint": names[j],
            "from [rad or m]": float(spans[j, 0]),
            "to": float(spans[j, 1]),
            "limits": f"{limits[j, 0]:.3g} ... {limits[j, 1]:.3g}" if finite[j] else "none",
            "of the range [%]": 100 * float(np.ptp(spans[j]) / width[j]) if finite[j] else None,
        }
        for j in range(len(names))
    )
    if outside.any():
        bad = ", ".join(names[j] for j in np.flatnonzero(outside))
        return Finding(
            "ranges",
            "amber",
            f"beyond the position limits of the robot's file: {bad}",
            "the joint's zero, sign or unit is not the file's, or the limits are not this arm's",
            rows,
        )
    return Finding(
        "ranges", "green", "all positions lie within the limits of the robot's file", "", rows
    )


def coverage_finding(dataset: DataSet) -> Finding:
    """What moved and how far in every role, and whether held-out motion goes where none was fitted."""
    travel = {role: _travel(dataset, role) for role in ROLES if _of(dataset, role)}
    names = dataset.robot.joint_names
    rows: list[EvidenceRow] = [
        {
            "joint": name,
            **{f"{role}: travel": float(x[j, 0]) for role, x in travel.items()},
            **{f"{role}: top speed": float(x[j, 1]) for role, x in travel.items()},
        }
        for j, name in enumerate(names)
    ]
    fitted = travel["estimation"][:, 0]
    beyond = [
        f"{names[j]} moves by {fitted[j]:.2g} in estimation, by {travel[role][j, 0]:.2g} in {role}"
        for role in HELD_OUT
        if role in travel
        for j in np.flatnonzero(travel[role][:, 0] > FAR * fitted)
    ]
    unchecked = [
        f"{name} in {role}"
        for role in HELD_OUT
        if role in travel
        for name in dataset.still_in(role)
        if name not in dataset.still
    ]
    told, remedies = [], []
    if beyond:
        told.append(
            "held-out recordings go where those for estimation never did: "
            f"{', '.join(beyond)} [rad or m]"
        )
        remedies.append("record estimation motion that covers at least what the arm is to do")
    if unchecked:
        told.append(
            f"stands still: {', '.join(unchecked)}; what is estimated of its friction and inertia is "
            "not checked there"
        )
        remedies.append("hold out a recording in which it moves")
    if told:
        text, remedy = "; ".join(told), "; ".join(remedies)
        return Finding("what moved", "amber", text, remedy, tuple(rows))
    if len(travel) == 1:
        return Finding(
            "what moved",
            "amber",
            "no recording is held out: nothing shows how well an estimate predicts",
            "add a recording of another motion with role validation",
            tuple(rows),
        )
    text = "held-out recordings stay where those for estimation were, within a factor of two"
    return Finding("what moved", "green", text, "", tuple(rows))


def _of(dataset: DataSet, role: str) -> tuple[Recording, ...]:
    return tuple(recording for recording in dataset.recordings if recording.role == role)


def _spans(recordings: tuple[Recording, ...]) -> Float[ndarray, "joints 2"]:
    lowest = np.min([recording.q.min(axis=0) for recording in recordings], axis=0)
    highest = np.max([recording.q.max(axis=0) for recording in recordings], axis=0)
    return np.column_stack([lowest, highest])


def _travel(dataset: DataSet, role: str) -> Float[ndarray, "joints 2"]:
    """Travel [rad or m] and top speed [rad/s or m/s] over a twentieth of a second."""
    recordings = _of(dataset, role)
    speeds = []
    for recording in recordings:
        stride = max(1, round(0.05 / float(np.median(np.diff(recording.t)))))
        step = (recording.t[stride:] - recording.t[:-stride])[:, None]
        moved = np.abs(recording.q[stride:] - recording.q[:-stride]) / step
        speeds.append(moved.max(axis=0, initial=0.0))
    return np.column_stack([np.ptp(_spans(recordings), axis=1), np.max(speeds, axis=0)])
