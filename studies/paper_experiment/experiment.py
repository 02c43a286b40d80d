"""Does the paper's experiment come back, and do its claims hold beyond one draw of the noise?

    python -m studies.paper_experiment [--out DIR] [--experiments N] [--workers N] [--smoke] [--seed N]

Designs the paper's trajectories, runs them on the simulated IMI arm, estimates and validates as
the paper did, repeats all of it hundreds of times, and leaves tables, the figures' data,
claims.csv and summary.md. Stages that nothing has changed for are read back from the cache.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from oed.dynamics.motion import Motion
from oed.experiment.drake_experiment import run_on_drake
from oed.experiment.imi_laboratory import Friction
from oed.experiment.paper_signals import PROCESSINGS, Processing
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import run as run_fast
from oed.report.json_file import write_atomically, write_json
from oed.report.output_folder import output_folder, results_folder
from oed.report.provenance import Provenance
from oed.report.table import write_csv
from studies.paper_experiment import figure_data as data
from studies.paper_experiment import tables
from studies.paper_experiment.campaign import (
    FRICTIONS,
    Bench,
    CampaignConfig,
    EnergyComparison,
    Experiment,
    ProcessingComparison,
    analyse,
    compare_energy,
    compare_processing,
    prepare,
    repetitions,
)
from studies.paper_experiment.claims import find_claims
from studies.paper_experiment.designs import (
    NAMES,
    DesignConfig,
    DesignSet,
    HorizonTable,
    design_all,
    sweep_horizons,
)
from studies.paper_experiment.monte_carlo import MonteCarlo, run_monte_carlo
from studies.paper_experiment.stage_cache import StageCache
from studies.paper_experiment.summary import PaperRows, claim_rows, summarise

PERIOD = 0.001  # [s], the paper's T
DYNAMICS = ("oed/robot", "oed/dynamics", "oed/design", "studies/paper_experiment/designs.py")
LABORATORY = (
    *DYNAMICS[:2],
    "oed/experiment",
    "oed/estimation",
    "studies/paper_experiment/campaign.py",
)


@dataclass(frozen=True)
class Config:
    """The whole study.

    Attributes:
        out: Where the results go.
        cache: Where finished stages are kept.
        designs: How trajectories are designed.
        campaign: How experiments are made.
        experiments: Of the Monte Carlo, a cell.
        processings: Of the signals in the Monte Carlo.
        comparisons: Experiments behind the tables of processing and energy.
        drake_seconds: How much of the J_k trajectory is run on Drake too [s].
        workers: Processes.
    """

    out: Path = Path("results/paper")
    cache: Path = Path("out/paper_cache")
    designs: DesignConfig = field(default_factory=DesignConfig)
    campaign: CampaignConfig = field(default_factory=CampaignConfig)
    experiments: int = 200
    processings: tuple[Processing, ...] = ("online", "parallel")
    comparisons: int = 40
    drake_seconds: float = 2.0
    workers: int = 2

    def smoke(self) -> Config:
        """The same study, as small as it can be."""
        return dataclasses.replace(
            self,
            designs=dataclasses.replace(
                self.designs,
                horizons=(2.0,),
                population=16,
                generations=6,
                runs=2,
                more_terms=(5,),
                exact_seconds=0.2,
            ),
            experiments=3,
            comparisons=2,
            drake_seconds=0.05,
            workers=1,
        )


@dataclass(frozen=True)
class DrakeCheck:
    """How far the compiled loop and Drake part, without resolvers.

    Attributes:
        duration: () of the trajectory's part [s].
        position: () largest difference of a joint [rad].
        command: () largest difference of a command [N m].
    """

    duration: np.ndarray
    position: np.ndarray
    command: np.ndarray


@dataclass(frozen=True)
class Result:
    """Everything that the study found."""

    horizons: HorizonTable
    designs: DesignSet
    bench: Bench
    single: tables.Single
    processing: dict[tuple[str, str], ProcessingComparison]
    energy: dict[tuple[str, str], EnergyComparison]
    monte_carlo: MonteCarlo
    drake: DrakeCheck


def run(config: Config) -> Result:
    """All stages, each read back where it is unchanged."""
    print("The paper's experiment", flush=True)
    cache, campaign = StageCache(config.cache), config.campaign
    key = cache.key("horizons", [config.designs], DYNAMICS)
    horizons = cache.get("horizons", key, HorizonTable, lambda: sweep_horizons(config.designs))
    horizon = float(horizons.chosen)
    key = cache.key("designs", [key], DYNAMICS)
    designs = cache.get(
        "designs", key, DesignSet, lambda: design_all(config.designs, horizon, PERIOD)
    )
    reference = designs.motion(0, PERIOD)
    key = cache.key("laboratory", [key, campaign], LABORATORY)
    bench = cache.get("laboratory", key, Bench, lambda: prepare(campaign, reference))
    drake = cache.get(
        "drake",
        cache.key("drake", [key, config.drake_seconds], []),
        DrakeCheck,
        lambda: check_drake(config, bench, reference),
    )
    single = tables.Single(
        *(
            _displayed(
                config, cache=cache, key=key, bench=bench, designs=designs, friction=friction
            )
            for friction in FRICTIONS
        )
    )
    processing, energy = _comparisons(config, cache, key, bench, designs)
    source = ["studies/paper_experiment/monte_carlo.py"]
    monte_carlo = cache.get(
        "monte_carlo",
        cache.key("monte_carlo", [key, config.experiments, config.processings], source),
        MonteCarlo,
        lambda: run_monte_carlo(
            campaign,
            bench,
            designs,
            config.processings,
            experiments=config.experiments,
            workers=config.workers,
        ),
    )
    return Result(horizons, designs, bench, single, processing, energy, monte_carlo, drake)


def check_drake(config: Config, bench: Bench, reference: Motion) -> DrakeCheck:
    """The start of the J_k trajectory on Drake and on the compiled loop, with one noise."""
    setup = bench.setup(config.campaign, "rich")
    # Which side of a resolver's step a rounding error falls on is chaos: without resolvers.
    setup = dataclasses.replace(setup, sensors=Sensors(), lead_in=0.2, lead_out=0.0)
    part = reference[: max(2, round(config.drake_seconds / PERIOD))]
    fast, drake = (
        runner(setup, part, np.random.default_rng(config.campaign.seed), runs=1)
        for runner in (run_fast, run_on_drake)
    )
    return DrakeCheck(
        np.array(len(part) * PERIOD + setup.lead_in),
        np.abs(fast.q - drake.q).max(),
        np.abs(fast.command - drake.command).max(),
    )


def write(result: Result, config: Config) -> None:
    """Tables, figure data, claims, summary and provenance."""
    out, truth = config.out, config.campaign.laboratory.truth()
    horizon = float(result.horizons.chosen)
    claims = find_claims(
        result.horizons, result.designs, result.monte_carlo, result.processing, truth
    )
    rows = PaperRows(
        comparison=tables.comparison(
            config.designs, config.campaign, result.designs, result.bench, result.single
        ),
        horizons=tables.horizons(result.horizons),
        terms=tables.terms(result.horizons),
        processing=tables.processing(result.processing, truth),
        energy=tables.energy(result.energy, truth),
        monte_carlo=tables.monte_carlo(result.monte_carlo, truth),
        claims=claims,
        drake=tables.table_rows(
            {f.name: getattr(result.drake, f.name)[None] for f in dataclasses.fields(DrakeCheck)}
        ),
        horizon=horizon,
        samples=config.designs.samples,
        experiments=config.experiments,
    )
    for name, listed in (
        ("comparison", rows.comparison),
        ("horizons", rows.horizons),
        ("terms", rows.terms),
        ("processing", rows.processing),
        ("energy", rows.energy),
        ("runs", rows.monte_carlo),
        ("claims", claim_rows(claims)),
        ("drake", rows.drake),
        ("figures/trajectories", data.trajectories(result.designs, PERIOD)),
        ("figures/designs", data.designs(result.designs)),
        ("figures/generations", data.generations(result.designs)),
        ("figures/torques", data.torques(result.single, horizon)),
        ("figures/recursion", data.recursion(result.single)),
        ("figures/bode", data.bode(config.campaign, result.bench)),
    ):
        write_csv(out / f"{name}.csv", listed)
    write_json(
        out / "figures/settings.json", data.settings(config.designs, config.campaign, horizon)
    )
    write_atomically(out / "summary.md", summarise(rows))
    Provenance.collect(config, seed=config.campaign.seed).write(out / "provenance.json")


def _displayed(
    config: Config,
    *,
    cache: StageCache,
    key: str,
    bench: Bench,
    designs: DesignSet,
    friction: Friction,
) -> tuple[Experiment, Experiment]:
    """The J_k and J_d experiments of the GA, once, as the paper shows them."""
    campaign, found = config.campaign, []
    for design in range(2):

        def compute(design: int = design) -> Experiment:
            logs = [
                repetitions(campaign, bench, friction, designs.motion(d, PERIOD), d)
                for d in (design, NAMES.index("test"))
            ]
            return analyse(campaign, logs[0], logs[1], PERIOD, "online")

        name = f"experiment_{friction}_{design}"
        found.append(cache.get(name, cache.key(name, [key], []), Experiment, compute))
    return found[0], found[1]


def _comparisons(
    config: Config, cache: StageCache, key: str, bench: Bench, designs: DesignSet
) -> tuple[dict[tuple[str, str], ProcessingComparison], dict[tuple[str, str], EnergyComparison]]:
    """Processings by design and friction, and energy by friction and processing."""
    campaign, count = config.campaign, config.comparisons
    processing, energy = {}, {}
    for friction in FRICTIONS:
        for design in ("J_k, GA", "J_d, GA", "J_d, Fourier"):
            motion = designs.motion(NAMES.index(design), PERIOD)
            name = f"processing_{friction}_{NAMES.index(design)}"
            processing[design, friction] = cache.get(
                name,
                cache.key(name, [key, count], []),
                ProcessingComparison,
                lambda motion=motion, design=design, friction=friction: compare_processing(
                    campaign,
                    bench,
                    motion,
                    friction=friction,
                    experiments=count,
                    periodic=design == "J_d, Fourier",
                ),
            )
        for way in ("online", "zero_phase"):
            name = f"energy_{friction}_{way}"
            energy[friction, way] = cache.get(
                name,
                cache.key(name, [key, count], []),
                EnergyComparison,
                lambda friction=friction, way=way: compare_energy(
                    campaign,
                    bench,
                    designs.motion(0, PERIOD),
                    way,
                    friction=friction,
                    experiments=count,
                ),
            )
    return processing, energy


def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description="The paper's experiment, in simulation.")
    parser.add_argument("--data", type=Path, help="ignored: this experiment is simulated")
    parser.add_argument("--out", type=output_folder, help="results/paper if not given")
    parser.add_argument("--cache", type=Path, default=Config.cache)
    parser.add_argument("--experiments", type=int, default=Config.experiments)
    parser.add_argument(
        "--processings", nargs="+", choices=PROCESSINGS[:-1], default=Config.processings
    )
    parser.add_argument("--workers", type=int, default=Config.workers)
    parser.add_argument("--seed", type=int, default=CampaignConfig.seed)
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
    write(run(config), config)
    print(f"left in {config.out}", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
