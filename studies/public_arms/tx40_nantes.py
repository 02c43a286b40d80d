"""The Staubli TX40 of Nantes, as figaroh has it (Nguyen, Lamiraux and others)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.column_names import joint_columns
from oed.experiment.importing.import_log import ImportChoices
from oed.experiment.recording import Role
from oed.experiment.write_dataset import write_columns
from oed.robot import load_robot
from studies.public_arms.arm import ONE_MOTION, Log, Peer, PublicArm, Torque
from studies.public_arms.base_table import read_table, torque_of_table

EXAMPLE = Path("examples/staubli_TX40")
URDF = Path("models/staubli_tx40_description/urdf/tx40_mdh_modified.urdf")
TABLE = EXAMPLE / "results/TX40_bp_5.csv"
RATE = 5000.0  # [Hz]
RATIO = np.array(
    [32.0, 32.0, 45.0, -48.0, 45.0, 32.0]
)  # motor turns a joint turn, as the config says
ZERO = np.array(
    [0.0, -np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0]
)  # [rad] of the joints at the encoders' zero
PARTS: tuple[tuple[Role, float, float], ...] = (
    ("estimation", 0.0, 4.5),  # [s]
    ("validation", 4.5, 6.0),
    ("test", 6.0, 7.5),  # then it stands, where friction is whatever it was left at
)


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001
    """Motor torques, brought to the joints."""
    return ImportChoices(robot=str(clone / URDF), torque="current", units={"tau": ("N m",)})


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:
    """Motor angles and torques at the joints; motor 6 turns with both axes of the wrist."""
    motor, drive = (
        pd.read_csv(clone / EXAMPLE / "data" / name).to_numpy()
        for name in ("pos_read_data.csv", "curr_data.csv")
    )
    turns = np.diag(RATIO)
    turns[5, 4] = RATIO[5]
    t = np.arange(len(motor)) / RATE
    q, tau = np.linalg.solve(turns, motor.T).T + ZERO, drive @ turns
    columns = dict(zip(joint_columns("q", 6), q.T, strict=True))
    columns |= dict(zip(joint_columns("tau", 6), tau.T, strict=True))
    found = []
    for role, start, end in PARTS:
        rows = (t >= start) & (t < end)
        path = folder / f"{role}.csv"
        write_columns(path, {"t": t[rows]} | {key: x[rows] for key, x in columns.items()})
        found.append(Log(path, role))
    return tuple(found)


def published(clone: Path, folder: Path) -> Torque:  # noqa: ARG001
    """The table's robot, and the inertia and friction of motor 6 that couple the wrist."""
    table = read_table(clone / TABLE, first=1)
    arm = torque_of_table(load_robot(clone / URDF), table)
    inertia, viscous, dry = (table[f"{x}_6"] for x in ("Iam", "fvm", "fsm"))

    def torque(motion: Motion) -> Float[ndarray, "samples joints"]:
        both = dry * np.sign(motion.dq[:, 4] + motion.dq[:, 5])
        result = arm(motion)
        result[:, 4] += inertia * motion.ddq[:, 5] + viscous * motion.dq[:, 5] + both
        result[:, 5] += inertia * motion.ddq[:, 4] + viscous * motion.dq[:, 4] + both
        return result

    return torque


ARM = PublicArm(
    name="TX40 (Nantes)",
    repository="thanhndv212/figaroh-plus",
    commit="c3b5172849b7",
    licence="Apache-2.0",
    marker=str(TABLE),
    choices=choices,
    logs=logs,
    protocol="9 s at 5 kHz: 0-4.5 s fitted, 4.5-6 s validation, 6-7.5 s sealed; then it stands",
    flatters=ONE_MOTION,
    peer=Peer(
        "figaroh's base parameters, with the coupling of the wrist's motors",
        "this motion whole, the sealed rows among it",
        published,
    ),
)
