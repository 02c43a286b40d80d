"""The patient side manipulator of the da Vinci research kit (Wang and others 2019)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from oed.experiment.column_names import joint_columns
from oed.experiment.importing.import_log import ImportChoices
from oed.experiment.recording import Role
from oed.experiment.write_dataset import write_columns
from studies.public_arms.arm import Log, Peer, PublicArm

DATA = Path("data/psm/measured_trajectory")
RATE = 200.0  # [Hz], as the published notebook has it
LOGGED, JOINTS = 7, 3  # yaw, pitch and insertion; the tool's four joints weigh next to nothing
SPLIT = 0.75  # of the fitted motion; what comes after is for validation
# Modified Denavit-Hartenberg table of the published notebook.
TABLE = """convention = "modified"
[[joint]]
name = "yaw"
a = 0.0
alpha = 1.5707963267948966
theta = 1.5707963267948966
[[joint]]
name = "pitch"
a = 0.0
alpha = -1.5707963267948966
theta = -1.5707963267948966
[[joint]]
name = "insertion"
kind = "prismatic"
a = 0.0
alpha = 1.5707963267948966
d = -0.4318
"""


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001
    """Torques of motor currents, at the joints."""
    table = folder / "psm.toml"
    table.write_text(TABLE, encoding="utf-8")
    units = {"tau": ("N m", "N m", "N")}
    return ImportChoices(robot=str(table), torque="current", units=units)


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:
    """Two motions without headers: of the first three quarters are fitted, the second is sealed."""
    one, two = (_columns(clone / DATA / f"{name}_results.csv") for name in ("one", "two"))
    cut = int(SPLIT * len(one["t"]))
    parts: tuple[tuple[Role, dict[str, np.ndarray]], ...] = (
        ("estimation", {key: x[:cut] for key, x in one.items()}),
        ("validation", {key: x[cut:] for key, x in one.items()}),
        ("test", two),
    )
    found = []
    for role, columns in parts:
        path = folder / f"{role}.csv"
        write_columns(path, columns)
        found.append(Log(path, role))
    return tuple(found)


def _columns(path: Path) -> dict[str, np.ndarray]:
    rows = pd.read_csv(path, header=None).to_numpy()
    columns = {"t": np.arange(len(rows)) / RATE}
    for k, quantity in enumerate(("q", "dq", "tau")):
        values = rows[:, k * LOGGED : k * LOGGED + JOINTS].T
        columns |= dict(zip(joint_columns(quantity, JOINTS), values, strict=True))
    return columns


ARM = PublicArm(
    name="dVRK PSM (Worcester)",
    repository="WPI-AIM/dvrk_dynamics_identification",
    commit="7697d3a6c908",
    licence="not stated",
    marker=str(DATA / "two_results.csv"),
    choices=choices,
    logs=logs,
    protocol="two motions of 30 s at 200 Hz: three quarters of the first fitted, the last validation, the "
    "second sealed",
    flatters="",
    peer=Peer(
        "parallelogram, counterweight and springs, feasible parameters",
        "the first motion",
        why_not="its equations are an archive of Python 2, and making them anew takes hours",
    ),
)
