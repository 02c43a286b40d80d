"""The double pendulum of the DFKI Underactuated Lab, design A.0."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.importing.import_log import ImportChoices
from oed.experiment.recording import Role
from studies.public_arms.arm import Log, Peer, PublicArm, Torque

RUNS = Path("data/experiment_records/design_A.0/20220812/sys_id")
MODEL = Path(
    "data/system_identification/identified_parameters/design_A.0/model_2.0/model_parameters.yml"
)
ROLES: dict[str, Role] = {
    "061157": "estimation",
    "060245": "estimation",
    "060440": "estimation",
    "060143": "validation",
    "060329": "test",
}
GRAVITY = 9.81  # [m/s^2]
# Two parallel axes, x along the links: gravity along x, so that zero hangs straight down.
TABLE = """convention = "modified"
[[joint]]
name = "shoulder"
a = 0.0
alpha = 0.0
[[joint]]
name = "elbow"
a = 0.3
alpha = 0.0
"""
FRICTION_SLOPE = 100.0  # of the arcus tangent by which the published model turns friction's sign


def choices(clone: Path, folder: Path) -> ImportChoices:  # noqa: ARG001
    """Commanded torques of two drives without sensors."""
    table = folder / "pendulum.toml"
    table.write_text(TABLE, encoding="utf-8")
    pairs = {
        x: (f"{name}1", f"{name}2") for x, name in (("q", "pos"), ("dq", "vel"), ("tau", "tau"))
    }
    return ImportChoices(
        robot=str(table),
        columns={"t": ("time",), **pairs},
        torque="commanded",
        gravity=(GRAVITY, 0.0, 0.0),
    )


def logs(clone: Path, folder: Path) -> tuple[Log, ...]:  # noqa: ARG001
    """Five runs of the session, two of them mirrored: that pair is validated and sealed."""
    return tuple(
        Log(clone / RUNS / f"20220812-{run}-PM_measured.csv", role) for run, role in ROLES.items()
    )


def published(clone: Path, folder: Path) -> Torque:  # noqa: ARG001
    """Two links, rotors and friction with the numbers of the clone."""
    p = yaml.safe_load((clone / MODEL).read_text(encoding="utf-8"))
    gr, Ir, l1, coupling = p["gr"], p["Ir"], p["l1"], p["m2"] * p["l1"] * p["r2"]

    def torque(motion: Motion) -> Float[ndarray, "samples joints"]:
        (q1, q2), (w1, w2), (a1, a2) = motion.q.T, motion.dq.T, motion.ddq.T
        turn, sway = coupling * np.cos(q2), coupling * np.sin(q2)
        m11 = p["I1"] + p["I2"] + p["m2"] * l1**2 + 2 * turn + (gr**2 + 1) * Ir
        m12, m22 = p["I2"] + turn - gr * Ir, p["I2"] + gr**2 * Ir
        g2 = p["m2"] * p["r2"] * p["g"] * np.sin(q1 + q2)
        g1 = (p["m1"] * p["r1"] + p["m2"] * l1) * p["g"] * np.sin(q1) + g2
        rigid = [
            m11 * a1 + m12 * a2 - sway * (2 * w1 + w2) * w2 + g1,
            m12 * a1 + m22 * a2 + sway * w1**2 + g2,
        ]
        friction = [
            p[f"b{j}"] * w + p[f"cf{j}"] * np.arctan(FRICTION_SLOPE * w)
            for j, w in ((1, w1), (2, w2))
        ]
        return np.add(rigid, friction).T

    return torque


ARM = PublicArm(
    name="Double pendulum (DFKI)",
    repository="dfki-ric-underactuated-lab/double_pendulum",
    commit="1e8544e67f3d",
    licence="BSD-3-Clause",
    marker=str(RUNS / "20220812-061157-PM_measured.csv"),
    choices=choices,
    logs=logs,
    protocol="three runs (95 s) fitted, one (10 s) validation, one (10 s) sealed",
    flatters="Runs of one session. The sealed run is the mirror image of the validation run, which has "
    "a say in what the loop adds.",
    peer=Peer(
        "model 2.0 of design A.0: two links, rotors, viscous friction and Coulomb friction",
        "runs of this session, which the repository does not list",
        published,
    ),
)
