"""Recordings of the paper's arm with an effect that its model does not declare.

    python -m studies.scara_recordings --out DIR [--hidden cable|stribeck|none] [--seed N] [--smoke]

Simulates the IMI laboratory (oed.experiment.imi_laboratory) on random periodic motions within the
paper's limits and writes a data set in the project's format. The data set says nothing of the
hidden effect: it is for trying out what reads data sets.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.commands.options import Count, Seed, parse
from oed.design.limits import repair
from oed.design.trajectories import FourierClass
from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.imi_recordings import HIDDEN, control_period, record_imi
from oed.experiment.recording import Role
from oed.experiment.write_dataset import write_dataset
from oed.process_end import leave
from oed.report.code_digest import code_digest
from oed.report.output_folder import check_output_folder
from oed.report.result_folder import ResultFiles
from oed.robot import imi_scara

ROLES: tuple[tuple[str, Role], ...] = (
    ("estimation_1", "estimation"),
    ("estimation_2", "estimation"),
    ("validation", "validation"),
    ("test", "test"),
)
HARMONICS = 5

FILES = ResultFiles("scara_recordings")
MODULE = "studies.scara_recordings"  # also where it is run as the main program


@dataclass(frozen=True)
class Config:
    """What to simulate.

    Attributes:
        out: Folder of the data set; empty, or of an earlier one of this study.
        hidden: The undeclared effect.
        period: Of each motion [s].
        repetitions: Of each motion.
        seed: Of motions and noise.
        smoke: Two repetitions of each motion.
    """

    out: Path
    hidden: str = "cable"
    period: float = 10.0
    repetitions: Count = 6
    seed: Seed = 0
    smoke: bool = False

    def __post_init__(self) -> None:
        check_output_folder(self.out)
        if self.hidden not in HIDDEN:
            raise ValueError(f"--hidden {self.hidden}: there are {', '.join(HIDDEN)}")

    @property
    def key(self) -> str:
        """Hash of all that decides the recordings."""
        settings = (self.hidden, self.period, self.repetitions, self.seed, self.smoke)
        return hashlib.sha256(f"{code_digest(MODULE)}{settings}".encode()).hexdigest()


def run(config: Config) -> DataSet:
    """Simulate all recordings."""
    rng = np.random.default_rng(config.seed)
    step = control_period()
    return record_imi(
        ((name, role, _random_motion(config.period, step, rng)) for name, role in ROLES),
        rng,
        hidden=config.hidden,
        repetitions=2 if config.smoke else config.repetitions,
        source="simulated: studies.scara_recordings",
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    config = parse(Config, prog="python -m studies.scara_recordings", arguments=arguments)
    if FILES.is_of(config.out, config.key):
        sys.stdout.write(f"{config.out} is there already: same code and settings\n")
        return 0
    with FILES.in_folder(config.out) as results, results.replaced(config.key) as new:
        write_dataset(run(config), new)
    sys.stdout.write(f"wrote {config.out}\n")
    return 0


def _random_motion(period: float, step: float, rng: np.random.Generator) -> Motion:
    """One period of a random Fourier series, as large as the paper's limits allow."""
    limits = imi_scara().limits
    series = FourierClass(period, limits, HARMONICS)
    start = rng.uniform(series.bounds[:, 0], series.bounds[:, 1])
    fitted = repair(series, start, limits)
    return series.motion(fitted, np.arange(round(period / step)) * step)


if __name__ == "__main__":
    leave(main, "studies.scara_recordings")
