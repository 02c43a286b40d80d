"""How much better and faster than figaroh, on the same arm, limits and cost?

    python -m studies.compare_figaroh --peer-python PYTHON [--robot URDF] [--seeds N] [--out DIR]

PYTHON is the interpreter of an environment with figaroh 1.0.2 and cyipopt, which need not be
this one. Both designs are judged here: the same torque model, base parameters and instants, J_k =
cond Lambda without column scaling, position, velocity and effort limits of the file.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from oed.commands.options import Count, parse
from oed.design.criteria import condition, information, log10_det
from oed.design.limits import violation_of
from oed.design.optimisers import interior_point, slsqp
from oed.design.optimisers.result import Budget
from oed.design.optimisers.target_hits import first_hit
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.process_end import leave
from oed.report.input_files import data_digest
from oed.report.json_file import write_atomically
from oed.report.provenance import Provenance
from oed.report.table import markdown_table, write_csv
from oed.robot import Robot, arm_joints, load_robot
from studies.data_folders import EXAMPLE_ROBOTS
from studies.study_options import StudyOptions

Row = dict[str, str | int | float]

UR5 = EXAMPLE_ROBOTS / "ur_description/urdf/ur5_robot.urdf"
PEER_SCRIPT = Path(__file__).with_name("figaroh_design.py")
DIGITS = 12  # of a digest in a file name
HORIZON = 8.0  # [s], four segments of two seconds
SAMPLES = 161  # figaroh's at 20 Hz, both ends included
OPTIMISERS = {"slsqp": slsqp.optimise, "interior-point": interior_point.optimise}


@dataclass(frozen=True)
class Config:
    """What is compared.

    Attributes:
        peer_python: Interpreter that has figaroh.
        robot: URDF of the arm.
        seeds: Of both, 0 ... seeds - 1.
        iterations: IPOPT's, for figaroh; its own default is 200.
        cpu_seconds: Given to each of our optimisers [s].
        timeout: For one run of figaroh, wall time [s].
    """

    peer_python: str
    robot: str = ""
    seeds: int = 3
    iterations: int = 60
    cpu_seconds: float = 15.0
    timeout: float = 1800.0


def run(config: Config, out: Path) -> list[Row]:
    """Rows of figaroh, then rows of ours; a run that fails is a row."""
    source = config.robot or str(UR5)
    robot = load_robot(source, joints=arm_joints(source))
    problem = _problem(robot)
    rows = [_peer_row(problem, source, seed, config, out) for seed in range(config.seeds)]
    found = [float(row["J_k"]) for row in rows if row["status"] == "found"]
    target = np.log10(min(found)) if found else np.nan
    for name in OPTIMISERS:
        rows += [_our_row(problem, name, seed, config, target) for seed in range(config.seeds)]
    return rows


def _problem(robot: Robot) -> DesignProblem:
    """Periodic motions at rest at the ends, as figaroh's; torque of the file's own inertia."""
    model = TorqueModel.standard(robot)
    motions = FourierClass(HORIZON, robot.limits, harmonics=5, at_rest=True)
    problem = DesignProblem(
        model,
        base_parameters(model),
        motions,
        robot.limits,
        np.linspace(0.0, HORIZON, SAMPLES),
        "J_k",
        nominal=_nominal(model),
    )
    start = problem.random_start(np.random.default_rng(0))
    problem.cost_and_gradient(start)  # compiles, which no run should pay for
    return problem


def _nominal(model: TorqueModel) -> np.ndarray:
    """The file's own inertia, without friction."""
    nominal = np.zeros(len(model.parameters))
    nominal[: len(model.robot.parameters)] = model.robot.parameters
    return nominal


def _peer_row(problem: DesignProblem, source: str, seed: int, config: Config, out: Path) -> Row:
    robot = problem.model.robot
    decides = (data_digest(source), config.iterations, robot.joint_names, PEER_SCRIPT.read_bytes())
    digest = hashlib.sha256(repr(decides).encode()).hexdigest()[:DIGITS]
    file = out / f"figaroh_{seed}_{digest}.json"
    if not file.is_file():
        out.mkdir(parents=True, exist_ok=True)
        asked = {
            "urdf": source,
            "out": str(file),
            "seed": seed,
            "iterations": config.iterations,
            "joints": list(robot.joint_names),
        }
        try:
            subprocess.run(  # noqa: S603 - the caller's own interpreter
                [config.peer_python, str(PEER_SCRIPT)],
                input=json.dumps(asked).encode(),
                check=True,
                timeout=config.timeout,
                capture_output=True,
            )
        except subprocess.CalledProcessError as error:
            last = error.stderr.decode(errors="replace").strip().splitlines()[-1:]
            why = last[0] if last else f"exit status {error.returncode}"
            return {"tool": "figaroh", "seed": seed, "status": f"failed: {why}"}
        except (OSError, subprocess.TimeoutExpired) as error:
            return {"tool": "figaroh", "seed": seed, "status": f"failed: {error}"}
    record = json.loads(file.read_text(encoding="utf-8"))
    row: Row = {"tool": "figaroh", "seed": seed, "cpu_s": record["cpu_s"]}
    if not record["is_found"]:
        return {**row, "status": "no feasible trajectory"}
    parts = (np.array(record[key], dtype=float) for key in ("T_F", "P_F", "V_F", "A_F"))
    t, q, dq, ddq = parts
    motion = Motion(t.reshape(-1), q, dq, ddq)
    columns = problem.base.reduce(problem.model.columns(motion))
    judged = information(columns)
    return {
        **row,
        "status": "found",
        "J_k": condition(judged),
        "J_d": log10_det(judged),
        "violation": _sampled_violation(problem, motion),
        "cond_W_of_figaroh": record["cond_W"],
        "base_parameters": record["base_parameters"],
        "version": record["versions"]["figaroh"],
    }


def _sampled_violation(problem: DesignProblem, motion: Motion) -> float:
    """Worst violation of position, velocity and torque at the samples, relative to the limit."""
    limits = problem.model.robot.limits
    torque = problem.model.torque(_nominal(problem.model), motion)
    worst = -1.0
    for kind, values in (("position", motion.q), ("velocity", motion.dq), ("torque", torque)):
        ranges = np.stack([values.min(axis=0), values.max(axis=0)], axis=1)
        worst = max(worst, float(violation_of(ranges, getattr(limits, kind)).max()))
    return worst


def _our_row(problem: DesignProblem, name: str, seed: int, config: Config, target: float) -> Row:
    rng = np.random.default_rng(seed)
    result = OPTIMISERS[name](problem, Budget(cpu_seconds=config.cpu_seconds), rng)
    judged = problem.information(result.z)
    return {
        "tool": f"oed, {name}",
        "seed": seed,
        "cpu_s": result.cpu_s,
        "status": "found",
        "J_k": condition(judged),
        "J_d": log10_det(judged),
        "violation": problem.certificate(result.z).violation,
        "base_parameters": len(problem.base),
        "cpu_s_to_best_of_figaroh": first_hit(result.history, "cpu_s", target),
    }


def write(rows: Sequence[Row], config: Config, out: Path) -> None:
    """Leave runs.csv, summary.md and provenance.json."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    write_csv(out / "runs.csv", [{c: row.get(c) for c in columns} for row in rows])
    text = f"""\
# Side by side with figaroh

The same arm, {SAMPLES} instants over {HORIZON:g} s, position, velocity and effort limits of the file; J_k = cond Lambda
of the same base columns, no scaling. figaroh: cubic splines through five waypoints, IPOPT with finite
differences, {config.iterations} iterations (its default is 200). Ours: Fourier series at rest at the ends, {config.cpu_seconds:g} CPU seconds. "violation" is
figaroh's at its samples, ours proven for all t; negative is inside. Neither has an acceleration limit.
Much of the difference is the class of motions: figaroh's splines come to rest at every waypoint.

{markdown_table(rows, columns=columns)}
{statement(rows)}
"""
    write_atomically(out / "summary.md", text)
    Provenance.collect(config, seed=None).write(out / "provenance.json")


def all_failed(rows: Sequence[Row]) -> bool:
    """Whether no run of figaroh came to its end."""
    peer = [row for row in rows if row["tool"] == "figaroh"]
    return all(str(row["status"]).startswith("failed") for row in peer)


def statement(rows: Sequence[Row]) -> str:
    """The medians against each other, in words."""
    peer = [row for row in rows if row["tool"] == "figaroh" and row["status"] == "found"]
    if all_failed(rows):
        return "figaroh did not run, so there is no ratio to state."
    if not peer:
        return "figaroh found no feasible trajectory in these runs, so there is no ratio to state."
    cost, seconds = (float(np.median([float(r[k]) for r in peer])) for k in ("J_k", "cpu_s"))
    sentences = [f"figaroh: median J_k {cost:.4g} in {seconds:.0f} CPU seconds."]
    for name in OPTIMISERS:
        ours = [row for row in rows if row["tool"] == f"oed, {name}"]
        value = float(np.median([float(r["J_k"]) for r in ours]))
        reach = float(np.median([float(r["cpu_s_to_best_of_figaroh"]) for r in ours]))
        sentences.append(
            f"\noed, {name}: median J_k {value:.4g}, {cost / value:.3g} times lower; figaroh's best "
            f"value is passed after a median of {reach:.3g} CPU seconds, {seconds / reach:.3g} "
            "times faster than figaroh's median run."
        )
    return "\n".join(sentences)


@dataclass(frozen=True, kw_only=True)
class Options(StudyOptions):
    """The same arm, limits and cost with figaroh.

    Attributes:
        peer_python: Interpreter of an environment that has figaroh 1.0.2.
        robot: URDF file; the UR5 if not given.
        seeds: Of both.
        iterations: IPOPT's, for figaroh.
        seconds: CPU time of each of our optimisers [s].
    """

    study: ClassVar[str] = "compare_figaroh"

    peer_python: str
    robot: str = ""
    seeds: Count = Config.seeds
    iterations: Count = Config.iterations
    seconds: float = Config.cpu_seconds

    @property
    def config(self) -> Config:
        """What is compared."""
        return Config(
            self.peer_python,
            self.robot,
            seeds=1 if self.smoke else self.seeds,
            iterations=self.iterations,
            cpu_seconds=1.0 if self.smoke else self.seconds,
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; 1 if figaroh did not run."""
    options = parse(Options, prog="python -m studies.compare_figaroh", arguments=arguments)
    with options.held([options.robot or UR5]) as results:
        rows = run(options.config, options.results)
        with results.replaced() as new:
            write(rows, options.config, new)
    return int(all_failed(rows))


if __name__ == "__main__":
    leave(main, "studies.compare_figaroh")
