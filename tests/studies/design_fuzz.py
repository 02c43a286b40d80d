"""Odd robots and odd wishes for the design command, and what must hold of every run.

    python -m tests.studies.design_fuzz [--runs 300] [--first 0]

Every case follows from its number alone. Of each run: an exit status that is documented, no
traceback, one line where it is refused, the robot's file untouched, nothing for a controller
unless the motion is usable, and then limits that a dense check by Drake and by the file's own
numbers does not refute.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import signal
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from oed.commands.options import parse
from tests.running import oed

FOR_A_CONTROLLER = ("motion.csv", "joint_trajectory.json", "joint_trajectory.yaml")
DEADLINE = 120  # [s] of a run by hand
# A share of a limit: digits of the file, and Drake's sums in another order.
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Bounds:
    """What the file says of a joint; None where it says nothing or nothing that can be."""

    position: tuple[float, float] | None
    velocity: float | None
    effort: float | None


@dataclass(frozen=True)
class Case:
    """One run.

    Attributes:
        urdf: Text of the robot's file.
        bounds: By joint.
        wishes: Options of the command.
    """

    urdf: str
    bounds: dict[str, Bounds]
    wishes: tuple[str, ...]

    @classmethod
    def number(cls, k: int) -> Case:
        """The case of that number."""
        rng = np.random.default_rng(k)
        count = int(rng.choice([1, 2, 3, 4], p=[0.2, 0.4, 0.25, 0.15]))
        links, bounds = ['<link name="link_0"/>'], {}
        for j in range(1, count + 1):
            parent = j - 1 if rng.random() < 0.9 else int(rng.integers(0, j))
            link, joint, bound = _link(rng, j, parent)
            links += [link, joint]
            bounds[f"joint_{j}"] = bound
        return cls(f'<robot name="odd">{"".join(links)}</robot>', bounds, _wishes(rng))


def _often(rng: np.random.Generator, usual: object, *odd: object) -> object:
    """The usual value nineteen times in twenty, else an odd one."""
    return usual if rng.random() < 0.95 else odd[int(rng.integers(len(odd)))]


def _link(rng: np.random.Generator, j: int, parent: int) -> tuple[str, str, Bounds]:
    kind = str(rng.choice(["revolute", "revolute", "continuous", "prismatic"]))
    lower = -rng.uniform(0.2, 3.0)
    position = _often(
        rng,
        (lower, lower + rng.uniform(0.3, 5.0)),
        (0.4, 0.401), (0.7, 0.7), (0.0, 0.0), (0.0, 1e-12), (1.0, -1.0), (-1e9, 1e9), (0.5, 0.53),
    )  # fmt: skip
    velocity = _often(rng, rng.uniform(0.3, 5.0), 0.0, 1e-6, 1e9, -1.0)
    effort = _often(rng, rng.uniform(20.0, 400.0), 0.0, 1e-3, 1e12, -5.0, 3.0)
    mass = _often(rng, rng.uniform(0.2, 6.0), 0.0, 1e-9, 1e6, -1.0)
    size = float(rng.uniform(0.02, 0.3))
    factor = float(_often(rng, 1.0, 0.0, 1e6, 1e-9))  # type: ignore[arg-type]
    moment = float(mass) * size**2 * factor  # type: ignore[arg-type]
    ratio = _often(rng, (1.0, 0.8, 0.6), (1.0, 0.1, 0.1), (-1.0, 1.0, 1.0))
    ixx, iyy, izz = (moment * r for r in ratio)  # type: ignore[attr-defined]
    shape = _often(
        rng,
        "",
        '<collision><geometry><sphere radius="0.05"/></geometry></collision>',
        '<collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision>',
        '<collision><geometry><mesh filename="package://gone/a.stl"/></geometry></collision>',
    )
    axis = ("1 0 0", "0 1 0", "0 0 1", "0 0.6 0.8")[int(rng.integers(4))]
    centre = " ".join(f"{c:.3f}" for c in rng.uniform(-0.2, 0.2, 3))
    step = " ".join(f"{c:.3f}" for c in rng.uniform(-0.3, 0.3, 3))
    link = (
        f'<link name="link_{j}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/><inertia '
        f'ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link>'
    )
    low, high = position  # type: ignore[misc]
    joint = (
        f'<joint name="joint_{j}" type="{kind}"><parent link="link_{parent}"/>'
        f'<child link="link_{j}"/><origin xyz="{step}"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" velocity="{velocity}" effort="{effort}"/></joint>'
    )
    is_range = kind != "continuous" and low < high
    return link, joint, Bounds(
        (low, high) if is_range else None,
        float(velocity) if float(velocity) > 0 else None,  # type: ignore[arg-type]
        float(effort) if float(effort) > 0 else None,  # type: ignore[arg-type]
    )  # fmt: skip


def _wishes(rng: np.random.Generator) -> tuple[str, ...]:
    wishes = ["--evaluations", str(rng.choice([1, 8, 30])), "--rate", "200"]
    wishes += ["--horizon", str(_often(rng, 10.0, 0.5, 2.0, 60.0))]
    wishes += ["--criterion", str(rng.choice(["J_k", "J_d", "A", "E"]))]
    wishes += ["--seed", str(rng.integers(3))]
    for wish in ("--periodic", "--no-torque", "--scaled-columns", "--avoid-collision"):
        wishes += [wish] if rng.random() < 0.15 else []
    if rng.random() < 0.15:
        size = float(rng.choice([0.2, 1.0, 3.0]))
        wishes += ["--box", *(f"{sign * size}" for _ in range(3) for sign in (-1, 1))]
    wishes += ["--model", "rotor"] if rng.random() < 0.1 else []
    return tuple(wishes)


def check(case: Case, folder: Path) -> tuple[int, str]:
    """Run a case in an empty folder; its exit status, and the line on standard error.

    Raises:
        AssertionError: If what must hold does not.
    """
    file, out = folder / "odd.urdf", folder / "out"
    file.write_text(case.urdf)
    said, complained = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
        code = oed("design", "--robot", file, "--out", out, "--smoke", *case.wishes)
    assert file.read_text() == case.urdf
    assert code in {0, 2, 3}, code
    assert complained.getvalue().count("\n") == (code != 0), complained.getvalue()
    assert sorted(p.name for p in folder.iterdir() if p.name != "out") == ["odd.urdf"]
    if code == 0:
        _check_motion(case, file, out, said.getvalue())
        return code, ""
    assert "proven feasible" not in said.getvalue()
    assert not any((out / name).exists() for name in FOR_A_CONTROLLER)
    assert code == 3 or not out.exists()
    return code, complained.getvalue().strip()


def _check_motion(case: Case, file: Path, out: Path, said: str) -> None:
    record = json.loads((out / "design.json").read_text())
    assert record["usable"]
    assert record["status"].split(";")[0] in said
    motion = pd.read_csv(out / "motion.csv")
    for name in record["joints"]:
        bound = case.bounds[name]
        for prefix, limit in (("q", bound.position), ("dq", bound.velocity)):
            if limit is None:
                continue
            low, high = limit if isinstance(limit, tuple) else (-limit, limit)
            values = motion[f"{prefix}_{name}"].to_numpy(dtype=float)
            slack = TOLERANCE * (high - low)
            assert values.min() >= low - slack, (name, prefix, values.min(), low)
            assert values.max() <= high + slack, (name, prefix, values.max(), high)
    standing = {limit["limit"]: limit["standing"] for limit in record["asked"]}
    if standing.get("torque") == "proven" and "ball of the same mass" not in said:
        _check_torque(case, file, motion, record["joints"], record["notes"])


def _check_torque(
    case: Case, file: Path, motion: pd.DataFrame, joints: list[str], notes: list[str]
) -> None:
    """Hold the torque that Drake computes against the file's effort limits."""
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(file)
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("link_0"))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    held = [re.match(r"(\S+) is held at (\S+):", note) for note in notes]
    rest = np.zeros(plant.num_positions())
    for found in held:
        if found:
            rest[plant.GetJointByName(found[1]).position_start()] = float(found[2])
    at = [plant.GetJointByName(name).position_start() for name in joints]
    forces = MultibodyForces(plant)
    for row in motion.iloc[:: max(1, len(motion) // 400)].to_dict("records"):
        q, v, a = rest.copy(), np.zeros_like(rest), np.zeros_like(rest)
        for k, name in zip(at, joints, strict=True):
            q[k], v[k], a[k] = (row[f"{prefix}_{name}"] for prefix in ("q", "dq", "ddq"))
        plant.SetPositions(context, q)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        plant.SetVelocities(context, v)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        forces.SetZero()
        plant.CalcForceElementsContribution(context, forces)
        torque = plant.CalcInverseDynamics(context, a, forces)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        for k, name in zip(at, joints, strict=True):
            effort = case.bounds[name].effort
            if effort is not None:
                assert abs(torque[k]) <= effort * (1 + 1e-3), (name, torque[k], effort)


@dataclass(frozen=True)
class Options:
    """Odd robots and wishes for the design command.

    Attributes:
        runs: Number of cases.
        first: Number of the first.
    """

    runs: int = 300
    first: int = 0


def _run_by_hand() -> int:
    given = parse(Options, prog="design_fuzz")
    counts: dict[str, int] = {}
    for k in range(given.first, given.first + given.runs):
        signal.alarm(DEADLINE)  # ends the run where it hangs
        with tempfile.TemporaryDirectory() as folder:
            try:
                code, told = check(Case.number(k), Path(folder))
                end = str(code)
            except Exception as error:  # noqa: BLE001  # a fault of any kind is what is looked for
                end, told = "fault", f"{type(error).__name__}: {error}"
        counts[end] = counts.get(end, 0) + 1
        print(f"case {k}: {end} {told}", flush=True)
    print(counts)
    return int("fault" in counts)


if __name__ == "__main__":
    raise SystemExit(_run_by_hand())
