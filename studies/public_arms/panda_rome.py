"""The Panda of Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca (2019)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oed.experiment.column_names import joint_columns
from oed.experiment.importing.import_log import ImportChoices
from oed.experiment.recording import Role
from oed.experiment.write_dataset import write_columns
from studies.data_folders import PANDA
from studies.public_arms.arm import ONE_MOTION, Log, Peer, PublicArm, Torque
from studies.public_arms.compiled import compiled, torque_of

LOGS = Path("matlab/data/Exciting_Traj/Trajectory_1/rbt_log")
CODE = Path("cpp/panda_dyn_model_example")
JOINTS = 7
PERIOD = 13.33  # [s] of the motion, after which its first 7.7 s come again
PARTS: tuple[tuple[str, Role, float, float], ...] = (
    ("estimation", "estimation", 0.0, 8.9),  # [s]
    ("validation", "validation", 8.9, 11.1),
    ("test", "test", 11.1, PERIOD),
    ("estimation_repeat", "estimation", PERIOD, np.inf),
)
WRAPPER = """
#include "franka_model.h"
using Vector = Eigen::Vector7d;
static Vector joints(const double* x) { return Eigen::Map<const Vector>(x); }
extern "C" void inertia(const double* q, double* out) {
  Eigen::Map<Eigen::Matrix7d>(out, 7, 7) = MassMatrix(joints(q));
}
extern "C" void gravity(const double* q, double* out) {
  Eigen::Map<Vector>(out, 7) = GravityVector(joints(q));
}
extern "C" void friction(const double* dq, double* out) {
  Eigen::Map<Vector>(out, 7) = Friction(joints(dq));
}
"""


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001
    """The torques are those of the joint sensors."""
    joints = tuple(f"panda_joint{j + 1}" for j in range(JOINTS))
    return ImportChoices(robot=str(PANDA), joints=joints, torque="measured")


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:
    """Four text files, seven lines a sample, joined and cut at whole periods of the motion."""
    t = _read(clone, "time").ravel()
    q, dq, tau = (
        _read(clone, name).reshape(-1, JOINTS) for name in ("positions", "velocity", "torques")
    )
    columns = {"t": t}
    for quantity, values in (("q", q), ("dq", dq), ("tau", tau)):
        columns |= dict(zip(joint_columns(quantity, JOINTS), values.T, strict=True))
    found = []
    for name, role, start, end in PARTS:
        rows = (t >= start) & (t < end)
        path = folder / f"{name}.csv"
        write_columns(path, {key: value[rows] for key, value in columns.items()})
        found.append(Log(path, role))
    return tuple(found)


def _read(clone: Path, name: str) -> np.ndarray:
    return np.loadtxt(clone / LOGS / f"exciting_traj_{name}.txt")


def published(clone: Path, folder: Path) -> Torque:
    """Mass matrix, gravity and sigmoid friction, as the clone has them."""
    names = ("MassMatrix", "GravityVector", "FrictionTorque")
    sources = [clone / CODE / "src" / f"{name}.cpp" for name in names]
    return torque_of(compiled(sources, [clone / CODE / "include"], WRAPPER, folder), JOINTS)


ARM = PublicArm(
    name="Panda (Rome)",
    repository="marcocognetti/FrankaEmikaPandaDynModel",
    commit="24d85ce4e648",
    licence="GPL-3.0: nothing of it is kept here",
    marker=str(LOGS / "exciting_traj_time.txt"),
    choices=choices,
    logs=logs,
    protocol="21 s at 1 kHz, period 13.33 s: 0-8.9 s and what repeats it fitted, 8.9-11.1 s validation, "
    "11.1-13.33 s sealed",
    flatters=ONE_MOTION,
    peer=Peer(
        "Gaz and others 2019: rigid body, sigmoid friction, feasible by penalties",
        "this motion, the sealed rows among it, and others",
        published,
    ),
)
