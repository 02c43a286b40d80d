"""The KUKA LBR Med7 of the lbr-stack."""

from __future__ import annotations

from pathlib import Path

from oed.experiment.importing.import_log import ImportChoices
from studies.public_arms.arm import ONE_MOTION, Log, Peer, PublicArm

LOG = Path("src/test/measurements.csv")
# The log's torques are those that the arm feels: against the file's inertials each correlates by -1.
FELT = -1.0
RATE = 100.0  # [Hz] that the published code takes the rows to have


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001
    """Joint torque sensors."""
    columns = {x: tuple(f"{x}_{j}" for j in range(7)) for x in ("q", "tau")}
    urdf = clone / "urdf/med/med7dock.urdf"
    felt = {"tau": (FELT,) * 7}
    return ImportChoices(robot=str(urdf), columns=columns, sign=felt, rate=RATE, torque="measured")


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:  # noqa: ARG001
    """One file without a time, divided by rows."""
    return (Log(clone / LOG),)


ARM = PublicArm(
    name="Med7 (London)",
    repository="lbr-stack/dynamic_parameter_identification",
    commit="58b4d88014db",
    licence="not stated",
    marker=str(LOG),
    choices=choices,
    logs=logs,
    protocol="16.5 s at 100 Hz: 60 % fitted, 20 % validation, 20 % sealed",
    flatters=ONE_MOTION,
    peer=Peer(
        "base parameters, Coulomb and viscous friction",
        "not stated",
        why_not="its numbers are coefficients of a regressor whose code needs ROS and optas",
    ),
)
