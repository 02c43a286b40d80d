"""Does the paper's experiment come back, and do its claims hold beyond one draw of everything?

    python -m studies.paper_experiment [--workers N] [--scheduler ADDRESS] [--cache DIR] [--smoke] [--seed N]

Designs the paper's trajectories from many seeds, runs them and test motions on the simulated IMI
arm with many draws of the noise, estimates and validates as the paper did, and leaves tables, the
figures' data, claims.csv and summary.md. Cases and stages that nothing has changed for are read back
from the cache: a run that was interrupted goes on where it stopped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.options import Seed, parse
from studies.paper_experiment.config import Config
from studies.paper_experiment.laboratory import LaboratoryConfig
from studies.paper_experiment.stage_cache import StageCache
from studies.paper_experiment.stages import run_stages
from studies.paper_experiment.writing import FILES, write
from studies.study_options import CaseOptions


@dataclass(frozen=True)
class Options(CaseOptions):
    """The paper's experiment, in simulation.

    Attributes:
        cache: Where finished stages are kept.
        seed: Of all noise.
    """

    study: ClassVar[str] = "paper"
    names: ClassVar[tuple[str, ...]] = FILES

    cache: Path = Config.cache
    seed: Seed = LaboratoryConfig.seed

    @property
    def config(self) -> Config:
        """The whole study."""
        whole = Config(self.results, self.cache, laboratory=LaboratoryConfig(seed=self.seed))
        return whole.smoke() if self.smoke else whole


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.paper_experiment", arguments=arguments)
    config = options.config
    print("The paper's experiment", flush=True)
    with options.held() as results:
        cache = StageCache(config.cache, options.workers, options.scheduler)
        found = run_stages(config, cache)
        with results.replaced() as new:
            write(found, config, new)
    print(f"left in {config.out}", flush=True)
    return 0
