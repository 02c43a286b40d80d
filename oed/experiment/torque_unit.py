"""In which unit stands what is called torque: N m, or amperes of which no constant makes torques.

A unit that is stated, and constants, decide. Of `torque = "current"` without either the robot's file
tells: where its own inertials need about as much as was logged, somebody has made torques of the
currents already.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.newton_euler import inverse_dynamics
from oed.experiment.manifest import Manifest
from oed.experiment.recording import Recording
from oed.robot import Robot
from oed.robot.robot import CONSTANTS

# Inertials of robot files give a joint's torque to its order of magnitude.
MAGNITUDE = np.sqrt(10.0)
TELLING = (
    0.7  # correlation with the weight by the file's inertials, friction apart: half of the variance
)
SAMPLES = 2000  # of a recording: weight changes slowly
WIDTH = 0.05  # [rad/s] over which friction turns its sign


def in_its_unit(robot: Robot, manifest: Manifest, recordings: Sequence[Recording]) -> Robot:
    """The robot with the unit of its recordings, and a note where nothing states it.

    Args:
        robot: Whose recordings these are.
        manifest: What `dataset.toml` says.
        recordings: At least one.
    """
    if manifest.drive.current_to_torque is not None:
        return robot
    if manifest.log.units.get("tau"):
        return _in_amperes(robot, "") if manifest.log.is_current else robot
    if manifest.torque != "current":
        return robot
    shares = _shares_of_weight(robot, recordings)
    told = {name: s for name, s in zip(robot.joint_names, shares, strict=True) if np.isfinite(s)}
    shown = ", ".join(f"{name} {share:.2g}" for name, share in told.items())
    if told and all(1 / MAGNITUDE < s < MAGNITUDE for s in told.values()):
        note = (
            'torque = "current" without current_to_torque and without a unit: taken for N m, since the '
            f"robot file's own inertials need as much (logged over needed: {shown}); if these are "
            'amperes, say so by units = {tau = "A"}'
        )
        return dataclasses.replace(robot, notes=(*robot.notes, note))
    why = f" (logged over what the robot file's inertials need: {shown})" if told else ""
    return _in_amperes(
        robot,
        f'torque = "current" without current_to_torque and without a unit is taken for amperes{why}; '
        'say units = {tau = "N m"} if these are torques; ',
    )


def _in_amperes(robot: Robot, why: str) -> Robot:
    note = (
        f"{why}parameters are in A per unit, and those that joints share are right only where their "
        f"drives have one constant; state {CONSTANTS}, in [drive] of dataset.toml"
    )
    return dataclasses.replace(robot.with_amperes(), notes=(*robot.notes, note))


def _shares_of_weight(robot: Robot, recordings: Sequence[Recording]) -> Float[ndarray, " joints"]:
    """(n,) logged torque over the file's weight, NaN where that does not explain it."""
    pieces = [_thinned(recording) for recording in recordings if len(recording) > 2]
    if not pieces:
        return np.full(robot.n, np.nan)
    q, dq, tau = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    rest = [0.0] * robot.n
    weight = inverse_dynamics(robot, list(np.ascontiguousarray(q.T)), rest, rest)
    return np.array(
        [_share(weight[j] + np.zeros(len(q)), dq[:, j], tau[:, j]) for j in range(robot.n)]
    )


def _thinned(recording: Recording) -> tuple[ndarray, ndarray, ndarray]:
    dq = np.gradient(recording.q, recording.t, axis=0) if recording.dq is None else recording.dq
    kept = slice(None, None, max(1, len(recording) // SAMPLES))
    return recording.q[kept], dq[kept], recording.tau[kept]


def _share(
    weight: Float[ndarray, " samples"],
    dq: Float[ndarray, " samples"],
    tau: Float[ndarray, " samples"],
) -> float:
    """Slope of the torque over the weight, friction and a constant apart."""
    beside = np.column_stack([np.tanh(dq / WIDTH), dq, np.ones(len(dq))])
    pair = np.column_stack([weight, tau])
    left = pair - beside @ np.linalg.lstsq(beside, pair, rcond=None)[0]
    squares = np.sum(left**2, axis=0)
    if not np.all(squares > 0):
        return float("nan")
    product = float(left[:, 0] @ left[:, 1])
    is_telling = abs(product) > TELLING * np.sqrt(squares[0] * squares[1])
    return abs(product) / float(squares[0]) if is_telling else float("nan")
