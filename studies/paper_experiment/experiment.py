"""Does the paper's experiment come back, and do its claims hold beyond one draw of the noise?

    python -m studies.paper_experiment [--out DIR] [--experiments N] [--workers N] [--smoke] [--seed N]

Designs the paper's trajectories, runs them on the simulated IMI arm, estimates and validates as
the paper did, repeats all of it hundreds of times, and leaves tables, the figures' data,
claims.csv and summary.md. Stages that nothing has changed for are read back from the cache.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.options import Count, Seed, parse
from oed.experiment.paper_signals import Processing
from studies.paper_experiment.campaign import CampaignConfig
from studies.paper_experiment.config import Config
from studies.paper_experiment.stages import run_stages
from studies.paper_experiment.writing import FILES, write
from studies.study_options import StudyOptions


@dataclass(frozen=True)
class Options(StudyOptions):
    """The paper's experiment, in simulation.

    Attributes:
        cache: Where finished stages are kept.
        experiments: Of the Monte Carlo, a cell.
        processings: Of the signals in the Monte Carlo.
        workers: Processes on this machine.
        seed: Of everything random.
    """

    study: ClassVar[str] = "paper"
    names: ClassVar[tuple[str, ...]] = FILES

    cache: Path = Config.cache
    experiments: Count = Config.experiments
    processings: tuple[Processing, ...] = Config.processings
    workers: Count = Config.workers
    seed: Seed = CampaignConfig.seed

    @property
    def config(self) -> Config:
        """The whole study."""
        whole = Config(
            out=self.results,
            cache=self.cache,
            experiments=self.experiments,
            processings=self.processings,
            workers=self.workers,
            campaign=CampaignConfig(seed=self.seed),
        )
        return whole.smoke() if self.smoke else whole


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.paper_experiment", arguments=arguments)
    config = options.config
    print("The paper's experiment", flush=True)
    with options.held() as results:
        found = run_stages(config)
        with results.replaced() as new:
            write(found, config, new)
    print(f"left in {config.out}", flush=True)
    return 0
