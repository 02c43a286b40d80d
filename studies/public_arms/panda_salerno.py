"""The Panda of the University of Salerno, with the model of Gaz and others (2019)."""

from __future__ import annotations

from pathlib import Path

from oed.experiment.importing.import_log import ImportChoices
from studies.data_folders import PANDA
from studies.public_arms.arm import ONE_MOTION, Log, Peer, PublicArm, Torque
from studies.public_arms.compiled import compiled, torque_of

PACKAGE = Path("franka_inria_inverse_dynamics_solver")
BAG = PACKAGE / "bagfiles/panda_exciting_trajectory.db3"
JOINTS = 7
SOURCES = ("get_MassMatrix_parziale", "get_GravityVector_eigen", "get_FrictionTorque")
WRAPPER = """
#include <Eigen/Core>
using Vector = Eigen::VectorXd;
Eigen::MatrixXf get_MassMatrix_partial(Eigen::VectorXf q);
Vector get_gravityvector(Vector q);
Vector get_friction(Vector dq);
static Vector joints(const double* x) { return Eigen::Map<const Vector>(x, 7); }
extern "C" void inertia(const double* q, double* out) {
  Eigen::Map<Eigen::MatrixXd>(out, 7, 7) = get_MassMatrix_partial(joints(q).cast<float>()).cast<double>();
}
extern "C" void gravity(const double* q, double* out) {
  Eigen::Map<Vector>(out, 7) = get_gravityvector(joints(q));
}
extern "C" void friction(const double* dq, double* out) {
  Eigen::Map<Vector>(out, 7) = get_friction(joints(dq));
}
"""


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001  # the bag names its joints
    """The efforts are those of the joint torque sensors."""
    return ImportChoices(robot=str(PANDA), torque="measured")


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:  # noqa: ARG001
    """The bag, divided by time."""
    return (Log(clone / BAG),)


def published(clone: Path, folder: Path) -> Torque:
    """Mass matrix, gravity and sigmoid friction, as the clone has them."""
    root = clone / PACKAGE
    sources = [root / "src" / f"{name}.cpp" for name in SOURCES]
    return torque_of(compiled(sources, [root / "include"], WRAPPER, folder), JOINTS)


ARM = PublicArm(
    name="Panda (Salerno)",
    repository="unisa-acg/inverse-dynamics-solver",
    commit="41e196de5ca3",
    licence="BSD-3-Clause",
    marker=str(BAG),
    choices=choices,
    logs=logs,
    protocol="24 s at about 30 Hz: 60 % fitted, 20 % validation, 20 % sealed",
    flatters=ONE_MOTION,
    peer=Peer(
        "Gaz and others 2019, as this repository has it: rigid body, sigmoid friction",
        "another Panda of the same make, another motion",
        published,
    ),
)
