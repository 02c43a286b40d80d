"""Can a million samples of a seven-joint arm be taken in, in bounded memory, and how fast?

    python -m studies.streaming [--samples N] [--out DIR] [--smoke]

Three rates in one run, all on one thread: the regressor and the streaming least squares of this
package; the regressor alone; and Pinocchio computing the same regressor rows one by one.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pinocchio

from oed.commands.options import Count, Seed, parse
from oed.dynamics.compiled import compile_regressor
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.streaming import StreamingLeastSquares
from oed.process_end import leave
from oed.report.json_file import write_atomically
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.table import Row, markdown_table, text_table, write_csv
from oed.robot import arm_joints, load_robot
from studies.data_folders import PANDA
from studies.study_options import StudyOptions

BLOCK = 2000  # samples taken in at once
PINOCCHIO_SAMPLES = 5000  # enough for a rate; the comparison is per sample
NOISE = 0.1  # [N m] of the simulated torque


@dataclass(frozen=True)
class Config:
    """How much to stream.

    Attributes:
        out: Folder to leave results in.
        samples: Samples of seven joints.
        seed: Of the motion and the noise.
    """

    out: Path = Path("results/streaming")
    samples: int = 1_000_000
    seed: int = 0


def run(config: Config) -> Row:
    """Stream, then time the regressor alone and Pinocchio's."""
    rng = np.random.default_rng(config.seed)
    robot = load_robot(PANDA, joints=arm_joints(PANDA))
    model = TorqueModel.standard(robot)
    base = base_parameters(model)
    regressor = compile_regressor(model, base)
    truth = base.from_standard(np.append(robot.parameters, np.full(2 * robot.n, 0.5)))
    stream = StreamingLeastSquares(len(base), robot.n)
    before = _peak_memory()
    spent = regressor_alone = 0.0
    for _ in progress(range(config.samples // BLOCK), "streaming"):
        motion = random_motion(robot, BLOCK, rng)
        start = time.perf_counter()
        rows = regressor.dense(regressor.entries(motion)).reshape(-1, len(base))
        regressor_alone += time.perf_counter() - start
        torque = rows @ truth + NOISE * rng.standard_normal(len(rows))
        start = time.perf_counter()
        stream.add(rows, torque)
        spent += time.perf_counter() - start
    solution = stream.solve()
    std = NOISE * np.linalg.norm(np.linalg.inv(solution.posterior_factor), axis=1)
    count = config.samples // BLOCK * BLOCK
    theirs = _pinocchio_rate(rng)
    return {
        "samples": count,
        "samples_per_s": count / (spent + regressor_alone),
        "regressor_per_s": count / regressor_alone,
        "pinocchio_regressor_per_s": theirs,
        "ratio_whole": count / (spent + regressor_alone) / theirs,
        "ratio_regressor": count / regressor_alone / theirs,
        "memory_growth_MB": (_peak_memory() - before) / 1e6,
        "worst_error_in_std": float(np.abs((solution.parameters - truth) / std).max()),
        "compiled": regressor.is_native,
    }


@dataclass(frozen=True)
class Options(StudyOptions):
    """Does a million samples of a seven-joint arm stream through in bounded memory?

    Attributes:
        samples: Samples of seven joints; 20,000 with --smoke.
        seed: Of the motion and the noise.
    """

    study: ClassVar[str] = "streaming"

    samples: Count = Config.samples
    seed: Seed = Config.seed


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    options = parse(Options, prog="python -m studies.streaming", arguments=arguments)
    samples = 20_000 if options.smoke else options.samples
    config = Config(out=options.results, samples=samples, seed=options.seed)
    with options.held() as results:
        row = run(config)
        table = [{"quantity": key, "value": value} for key, value in row.items()]
        with results.replaced() as new:
            write_csv(new / "runs.csv", [row])
            write_atomically(new / "summary.md", f"# Streaming\n\n{markdown_table(table)}\n")
            Provenance.collect(config, seed=config.seed).write(new / "provenance.json")
    sys.stdout.write(text_table(table) + "\n")
    return 0


def _pinocchio_rate(rng: np.random.Generator) -> float:
    """Samples a second of Pinocchio's regressor, called once a sample."""
    model = pinocchio.buildModelFromUrdf(str(PANDA))
    data = model.createData()
    states = rng.uniform(-1.0, 1.0, (PINOCCHIO_SAMPLES, 3, model.nq))
    start = time.perf_counter()
    for q, dq, ddq in states:
        pinocchio.computeJointTorqueRegressor(model, data, q, dq, ddq)
    return PINOCCHIO_SAMPLES / (time.perf_counter() - start)


def _peak_memory() -> float:
    """Largest memory of this process so far [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0


if __name__ == "__main__":
    leave(main, "studies.streaming")
