"""Joints whose torque or current is logged with the opposite sign, refused before a load is made of them.

Two witnesses tell, whatever the arm holds. Friction brakes a joint: where it would drive it, the sign is
the other one. And the torque goes with that of the robot file's inertials, not against it. Each says how
strongly, as a share of 1; a joint is named where one is clear and their sum is negative.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool
from numpy import ndarray

from oed.checkup.projection import SUSPECT, Projection, project
from oed.counted import counted
from oed.dynamics.torque_model import TorqueModel
from oed.errors import NoUsableResult
from oed.estimation.dissipation import CLEAR_SHARE
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording


def check_signs(
    dataset: DataSet, model: TorqueModel, recordings: tuple[ProcessedRecording, ...]
) -> None:
    """Refuse recordings of which a joint's torque has the opposite sign.

    Args:
        dataset: That they are of.
        model: With a rigid body and friction.
        recordings: In one band.

    Raises:
        NoUsableResult: In one line that names the joints, with the evidence and what to do.
    """
    found = project(model, {"estimation": recordings})
    joints = np.flatnonzero(are_reversed(found)).tolist()
    if not joints:
        return
    names = dataset.robot.joint_names
    what = "current" if dataset.torque == "current" else "torque"
    shown = ", ".join(
        f"{names[j]} (friction takes {found.braking[j]:+.0%} of its power, correlation with the robot "
        f"file's torque {found.correlation[j]:+.2f})"
        for j in joints
    )
    signs = [-1 if j in joints else 1 for j in range(len(names))]
    raise NoUsableResult(
        f"{dataset.name}: the {what} of {counted(len(joints), 'joint')} has the opposite sign: {shown}; "
        f"say sign = {{tau = {signs}}} in dataset.toml"
    )


def are_reversed(found: Projection) -> Bool[ndarray, " joints"]:
    """(n,) whether a witness clearly says so, and both together do."""
    clear = (found.braking < -CLEAR_SHARE) | (found.correlation <= -SUSPECT)
    return clear & (found.braking + found.correlation < 0)
