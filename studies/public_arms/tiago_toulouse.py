"""The TIAGo of LAAS-CNRS, as figaroh has it: torso and left arm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from oed.experiment.column_names import joint_columns
from oed.experiment.importing.import_log import ImportChoices
from oed.experiment.write_dataset import write_columns
from oed.robot import Robot, load_robot
from studies.public_arms.arm import ONE_MOTION, Log, Peer, PublicArm, Torque
from studies.public_arms.base_table import read_table, torque_of_table

EXAMPLE = Path("examples/tiago")
DATA = EXAMPLE / "data/identification/dynamic"
URDF = EXAMPLE / "urdf/tiago_48_schunk.urdf"
JOINTS = ("torso_lift_joint", *(f"arm_{j}_joint" for j in range(1, 8)))
TORSO = 13  # the table's number of the torso: what comes before is the base with its wheels
MOVING = slice(921, 6791)  # rows that the published example uses
# N m a logged unit of effort at the joints, as the published example multiplies them.
GAINS = np.array([1.0, *(100 * x for x in (0.136, 0.136, -0.087, -0.087)), *[336 * -0.0613] * 3])
GRAVITY = 9.81  # [m/s^2]


def robot_of(clone: Path) -> Robot:
    """Torso and arm; wheels and gripper stand still."""
    return load_robot(clone / URDF, joints=JOINTS)


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001
    """Currents that the published example makes torques of."""
    units = {"tau": ("N", *["N m"] * 7)}
    return ImportChoices(robot=str(clone / URDF), joints=JOINTS, torque="current", units=units)


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:
    """Three files, a column a joint, joined; the torso's effort lacks the weight that it carries."""
    columns = {}
    for quantity, name in (("q", "position"), ("dq", "velocity"), ("tau", "effort")):
        frame = pd.read_csv(clone / DATA / f"tiago_{name}.csv").iloc[MOVING]
        columns["t"] = frame["t"].to_numpy()
        values = frame.drop(columns="t").to_numpy().T
        columns |= dict(zip(joint_columns(quantity, len(JOINTS)), values, strict=True))
    for gain, name in zip(GAINS, joint_columns("tau", len(JOINTS)), strict=True):
        columns[name] = gain * columns[name]
    columns["tau_1"] = columns["tau_1"] + GRAVITY * robot_of(clone).parameters[::10].sum()
    path = folder / "tiago.csv"
    write_columns(path, columns)
    return (Log(path),)


def published(clone: Path, folder: Path) -> Torque:  # noqa: ARG001
    """The table's robot, which has no friction."""
    table = read_table(clone / DATA / "tiago_bp_19_Oct_2024_2320.csv", first=TORSO)
    return torque_of_table(robot_of(clone), table)


ARM = PublicArm(
    name="TIAGo (Toulouse)",
    repository="thanhndv212/figaroh-plus",
    commit="c3b5172849b7",
    licence="Apache-2.0",
    marker=str(DATA / "tiago_effort.csv"),
    choices=choices,
    logs=logs,
    protocol="59 s at 100 Hz: 60 % fitted, 20 % validation, 20 % sealed",
    flatters=ONE_MOTION,
    peer=Peer(
        "figaroh's base parameters: rigid body alone",
        "this motion whole, the sealed rows among it",
        published,
    ),
)
