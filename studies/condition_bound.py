"""How small can the condition number of any excitation be?

    python -m studies.condition_bound --out DIR [--smoke]

Bounds J_k = cond Lambda of every motion of the paper's arm within its limits from below, whatever its
parametrisation, and proves the bound over all states.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from oed.commands.options import Seed, parse
from oed.design.bound.condition_bound import ConditionSettings, condition_bound
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.process_end import leave
from oed.report.json_file import write_atomically
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.table import Row, markdown_table, write_csv
from oed.robot import load_robot
from studies.study_options import StudyOptions


@dataclass(frozen=True)
class Config:
    """What is bounded.

    Attributes:
        margins: Shares of the sampled optimum that are given up for the proof, one bound each.
        seed: Of the states that are looked at.
        bound: Settings of the bound.
    """

    margins: tuple[float, ...] = (0.1, 0.03)
    seed: int = 0
    bound: ConditionSettings = field(default_factory=ConditionSettings)


def run(config: Config) -> list[Row]:
    """A bound for each margin."""
    robot = load_robot("builtin:imi_scara")
    model = TorqueModel.standard(robot)
    base, rows = base_parameters(model), []
    for margin in progress(config.margins, "bounds"):
        started = time.process_time()
        settings, rng = replace(config.bound, margin=margin), np.random.default_rng(config.seed)
        found = condition_bound(model, base, robot.limits, rng, settings)
        row: Row = {"margin": margin, "J_k_bound": found.J_k, "J_k_of_best_measure": found.sampled}
        rows.append({**row, "boxes": found.boxes, "cpu_s": time.process_time() - started})
    return rows


def write(rows: list[Row], config: Config, out: Path) -> None:
    """Leave runs.csv, summary.md and provenance.json."""
    write_csv(out / "runs.csv", rows)
    best = max(rows, key=lambda row: float(str(row["J_k_bound"])))
    text = f"""\
# How small the condition number can be

The paper's arm and limits, R_v = I, base parameters in SI units, columns as they are. No motion within the
limits, of any parametrisation and length, has a continuous-time J_k = cond Lambda below **{best["J_k_bound"]:.4g}**:
a certificate was checked over all states by branch and bound, those of joints at rest too. The motion is one
that the arm can come to from rest and stop after.

The relaxation ignores that states lie on one trajectory: it mixes states freely, and no motion need come near.
The best mixture of the states that were looked at has the condition number in the third column, so that no
certificate of this kind proves more; the margin is what was given up of it for the proof.

{markdown_table(rows)}"""
    write_atomically(out / "summary.md", text)
    Provenance.collect(config, seed=config.seed).write(out / "provenance.json")


@dataclass(frozen=True)
class Options(StudyOptions):
    """How small the condition number of any motion can be.

    Attributes:
        seed: Of the states that are looked at.
    """

    study: ClassVar[str] = "condition_bound"

    seed: Seed = Config.seed

    @property
    def config(self) -> Config:
        """What is bounded."""
        if not self.smoke:
            return Config(seed=self.seed)
        return Config((0.6,), self.seed, ConditionSettings(searched=20_000))


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.condition_bound", arguments=arguments)
    with options.held() as results:
        found = run(options.config)
        with results.replaced() as new:
            write(found, options.config, new)
    return 0


if __name__ == "__main__":
    leave(main, "studies.condition_bound")
