"""The UR10 of the University of Salerno (Petrone, Ferrentino, Chiacchio 2025)."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.importing.import_log import ImportChoices
from studies.data_folders import EXAMPLE_ROBOTS
from studies.public_arms.arm import ONE_MOTION, Log, Peer, PublicArm, Torque
from studies.public_arms.compiled import compiled

PACKAGE = Path("ur10_inverse_dynamics_solver")
BAG = PACKAGE / "bagfiles/ur10_exciting_trajectory.db3"
JOINTS = 6
WRAPPER = """
#include "ur10_inverse_dynamics_solver/getCurrents.h"
extern "C" void currents(const double* q, const double* dq, const double* ddq, double* out) {
  ur10_inverse_dynamics_solver::getCurrents(q, dq, ddq, out);
}
"""


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001  # the bag names its joints
    """The bag's efforts are what the driver makes torques of currents."""
    robot = EXAMPLE_ROBOTS / "ur_description/urdf/ur10_robot.urdf"
    return ImportChoices(robot=str(robot), torque="current", units={"tau": ("N m",)})


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:  # noqa: ARG001
    """The bag, divided by time."""
    return (Log(clone / BAG),)


def published(clone: Path, folder: Path) -> Torque:
    """Rigid-body currents, sigmoid friction and drive gains, as the clone has them."""
    root = clone / PACKAGE
    name = "ur10_inverse_dynamics_solver"
    library = compiled([root / "src/getCurrents.cpp"], [root / "include"], WRAPPER, folder)
    source = (root / "src" / f"{name}.cpp").read_text(encoding="utf-8")
    header = (root / "include" / name / f"{name}.h").read_text(encoding="utf-8")
    gains = np.array([float(x) for x in re.findall(r"double K\d = ([\d.]+);", header)])
    f_v, f_o, f_c, alpha, shift = (
        _numbers(source, x) for x in ("f_v", "f_o", "f_c", "alpha", "ni")
    )

    def torque(motion: Motion) -> Float[ndarray, "samples joints"]:
        sigmoid = f_c / (1 + np.exp(-alpha * (motion.dq + shift)))
        rigid = library.call("currents", JOINTS, motion.q, motion.dq, motion.ddq)
        return gains * (rigid + f_v * motion.dq + f_o + sigmoid)

    return torque


def _numbers(source: str, name: str) -> Float[ndarray, " joints"]:
    """What the source assigns to the elements of a vector."""
    found = re.findall(rf"\b{name}\(\d\) = (-?[\d.]+);", source)
    if len(found) != JOINTS:
        raise ValueError(f"the published source has {len(found)} numbers of {name}, not {JOINTS}")
    return np.array([float(x) for x in found])


ARM = PublicArm(
    name="UR10 (Salerno)",
    repository="unisa-acg/inverse-dynamics-solver",
    commit="41e196de5ca3",
    licence="BSD-3-Clause",
    marker=str(BAG),
    choices=choices,
    logs=logs,
    protocol="27.5 s at 125 Hz: 60 % fitted, 20 % validation, 20 % sealed",
    flatters=ONE_MOTION,
    peer=Peer(
        "Petrone, Ferrentino and Chiacchio 2025: rigid body in amperes, sigmoid friction, drive gains",
        "not stated in the repository; this motion may be among it",
        published,
    ),
)
