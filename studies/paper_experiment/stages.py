"""The stages of the study: designs, laboratory, experiments, and all of it again and again.

A stage that nothing has changed for is read back from the cache.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from oed.dynamics.motion import Motion
from oed.experiment.drake_experiment import run_on_drake
from oed.experiment.imi_laboratory import Friction
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import run as run_fast
from studies.paper_experiment import tables
from studies.paper_experiment.campaign import (
    FRICTIONS,
    Bench,
    EnergyComparison,
    Experiment,
    ProcessingComparison,
    analyse,
    compare_energy,
    compare_processing,
    prepare,
    repetitions,
)
from studies.paper_experiment.config import PERIOD, Config
from studies.paper_experiment.designs import (
    NAMES,
    DesignSet,
    HorizonTable,
    design_all,
    sweep_horizons,
)
from studies.paper_experiment.monte_carlo import MonteCarlo, run_monte_carlo
from studies.paper_experiment.stage_cache import StageCache

DESIGNS = ("studies.paper_experiment.designs",)
LABORATORY = ("studies.paper_experiment.campaign",)


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


def run_stages(config: Config) -> Result:
    """All stages, each read back where it is unchanged."""
    cache, campaign = StageCache(config.cache), config.campaign
    key = cache.key("horizons", [config.designs], DESIGNS)
    horizons = cache.get("horizons", key, HorizonTable, lambda: sweep_horizons(config.designs))
    horizon = float(horizons.chosen)
    key = cache.key("designs", [key], DESIGNS)
    designs = cache.get(
        "designs", key, DesignSet, lambda: design_all(config.designs, horizon, PERIOD)
    )
    reference = designs.motion(0, PERIOD)
    key = cache.key("laboratory", [key, campaign], LABORATORY)
    bench = cache.get("laboratory", key, Bench, lambda: prepare(campaign, reference))
    drake = cache.get(
        "drake",
        cache.key("drake", [key, config.drake_seconds], [check_drake.__module__]),
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
    monte_carlo = cache.get(
        "monte_carlo",
        cache.key(
            "monte_carlo",
            [key, config.experiments, config.processings],
            [run_monte_carlo.__module__],
        ),
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
