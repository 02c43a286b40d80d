"""What to record instead: the motion that is there already, so that a design completes it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping

import numpy as np

from oed.dynamics.motion import Motion
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings

# As a design samples its motion: 200 instants in 10 s (`oed.design.default_problem`).
RATE = 20.0  # [Hz]: the motion of an arm, of a few hertz, has no more to tell at more instants
LONGEST = 50_000  # instants; of a longer log every second one, and so on


def recorded_motion(dataset: DataSet, settings: ProcessingSettings) -> Mapping[str, object]:
    """The estimation recordings' motion, for `design --prior`.

    Args:
        dataset: With recordings for estimation.
        settings: Of the signal processing.

    Returns:
        A JSON record: joints, t [s], and q, dq, ddq (instants by joints).
    """
    parts = [
        recording.motion[:: max(1, round(recording.rate / RATE))]
        for recording in process_all(dataset, settings)["estimation"]
    ]
    step = -(-sum(len(part) for part in parts) // LONGEST)
    q, dq, ddq = (
        np.concatenate([getattr(part, signal)[::step] for part in parts])
        for signal in ("q", "dq", "ddq")
    )
    t = np.arange(len(q)) * step / RATE
    whole = Motion(t, q, dq, ddq)
    return {
        "class": "recorded",
        "joints": list(dataset.robot.joint_names),
        "t": whole.t,
        "q": whole.q,
        "dq": whole.dq,
        "ddq": whole.ddq,
    }


def design_command(
    data: str, motion: str, out: str, *, model: str, joints: tuple[str, ...] = ()
) -> str:
    """The command that designs a motion to complete what is recorded.

    Args:
        data: Folder of the data set.
        motion: File with its recorded motion.
        out: Folder for the design.
        model: Name of the torque model that is to be determined.
        joints: Names of the joints; all if empty.
    """
    words = ["oed", "design", "--data", data, "--model", model]
    if joints:
        words += ["--joints", *joints]
    words += ["--prior", motion, "--out", out]
    return shlex.join(words)
