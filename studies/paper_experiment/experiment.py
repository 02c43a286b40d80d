"""Does the paper's experiment come back, and do its claims hold beyond one draw of the noise?

    python -m studies.paper_experiment [--out DIR] [--experiments N] [--workers N] [--smoke] [--seed N]

Designs the paper's trajectories, runs them on the simulated IMI arm, estimates and validates as
the paper did, repeats all of it hundreds of times, and leaves tables, the figures' data,
claims.csv and summary.md. Stages that nothing has changed for are read back from the cache.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from oed.experiment.paper_signals import PROCESSINGS
from oed.report.output_folder import output_folder, results_folder
from studies.paper_experiment.campaign import CampaignConfig
from studies.paper_experiment.config import Config
from studies.paper_experiment.stages import run_stages
from studies.paper_experiment.writing import write
from studies.whole_numbers import from_one, from_zero


def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description="The paper's experiment, in simulation.")
    parser.add_argument("--out", type=output_folder, help="results/paper if not given")
    parser.add_argument("--cache", type=Path, default=Config.cache)
    parser.add_argument("--experiments", type=from_one, default=Config.experiments)
    parser.add_argument(
        "--processings", nargs="+", choices=PROCESSINGS[:-1], default=Config.processings
    )
    parser.add_argument("--workers", type=from_one, default=Config.workers)
    parser.add_argument("--seed", type=from_zero, default=CampaignConfig.seed)
    parser.add_argument("--smoke", action="store_true", help="as small as can be")
    given = parser.parse_args(argv)
    given.out = given.out or results_folder("paper", smoke=given.smoke)
    config = Config(
        out=given.out,
        cache=given.cache,
        experiments=given.experiments,
        processings=tuple(given.processings),
        workers=given.workers,
        campaign=CampaignConfig(seed=given.seed),
    )
    config = config.smoke() if given.smoke else config
    print("The paper's experiment", flush=True)
    write(run_stages(config), config)
    print(f"left in {config.out}", flush=True)
    return 0
