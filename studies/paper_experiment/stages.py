"""The stages of the study: searches, designs, laboratory, and experiments, all crossed.

A stage that nothing has changed for is read back from the cache.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.drake_experiment import run_on_drake
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import run as run_fast
from studies.paper_experiment.campaign import Campaign, Conditions, run_campaign
from studies.paper_experiment.config import Config
from studies.paper_experiment.designs import DesignSet, design_all, reference
from studies.paper_experiment.fitness import Fitness
from studies.paper_experiment.laboratory import PERIOD, Bench, prepare
from studies.paper_experiment.searches import (
    DesignConfig,
    HorizonTable,
    Searches,
    at_half_the_instants,
    runs_of,
    search,
    sweep_horizons,
)
from studies.paper_experiment.shown import Shown, show
from studies.paper_experiment.stage_cache import StageCache


@dataclass(frozen=True)
class DrakeCheck:
    """How far the compiled loop and Drake part, without resolvers.

    Attributes:
        duration: () of the trajectory's part [s].
        position: () largest difference of a joint [rad].
        command: () largest difference of a command [N m].
    """

    duration: ndarray
    position: ndarray
    command: ndarray


@dataclass(frozen=True)
class Result:
    """Everything that the study found.

    Attributes:
        horizons: What the unstated T does.
        searches: Runs of the algorithm.
        designs: What is run on the arm.
        references: K kinds of P designs' motions.
        tests: T test motions.
        bench: The laboratory.
        drake: The loop beside Drake.
        shown: The experiments of the figures, for J_k and J_d.
        campaign: All experiments.
    """

    horizons: HorizonTable
    searches: Searches
    designs: DesignSet
    references: list[list[Motion]]
    tests: list[Motion]
    bench: Bench
    drake: DrakeCheck
    shown: tuple[Shown, Shown]
    campaign: Campaign

    @property
    def shown_references(self) -> list[Motion]:
        """The designs of the figures, for J_k and J_d, and their test motion."""
        return [self.references[k][run] for k, run in enumerate(self.designs.shown)] + [
            self.tests[0]
        ]

    def speed(self) -> Float[ndarray, "K P n"]:
        """Rms speed of the joints [rad/s]."""
        return np.array([[np.sqrt((m.dq**2).mean(axis=0)) for m in own] for own in self.references])


def run_stages(config: Config, cache: StageCache) -> Result:
    """All stages, each read back where it is unchanged."""
    sizes, laboratory = config.designs, config.laboratory
    key = cache.key("designs", [sizes], [design_all.__module__])
    horizons = sweep_horizons(sizes, cache)
    horizon = float(horizons.chosen)
    found = _search(cache, sizes, horizon)
    designs = cache.get("designs", key, DesignSet, lambda: design_all(sizes, horizon, found, cache))
    asked = partial(reference, sizes.terms, horizon, period=PERIOD)
    references = [[asked(z) for z in own] for own in designs.z]
    tests = [asked(z) for z in designs.tests]
    shown_references = [references[k][run] for k, run in enumerate(designs.shown)]
    key = cache.key("laboratory", [key, laboratory], [prepare.__module__])
    bench = cache.get("laboratory", key, Bench, lambda: prepare(laboratory, shown_references[0]))
    drake = cache.get(
        "drake",
        cache.key("drake", [key, config.drake_seconds], [check_drake.__module__]),
        DrakeCheck,
        lambda: check_drake(config, bench, shown_references[0]),
    )
    shown_key = cache.key("shown", [key], [show.__module__])
    shown = [
        cache.get(
            f"shown_{kind}",
            shown_key,
            Shown,
            partial(show, laboratory, bench, motion, tests[0], kind),
        )
        for kind, motion in enumerate(shown_references)
    ]
    ready = tuple(tuple(x.tolist()) for x in vars(bench).values())
    conditions = Conditions(laboratory, ready, config.draws, horizon, sizes.terms)
    campaign = run_campaign(conditions, designs, cache)
    pair = (shown[0], shown[1])
    return Result(horizons, found, designs, references, tests, bench, drake, pair, campaign)


def _search(cache: StageCache, sizes: DesignConfig, horizon: float) -> Searches:
    """Every run of the algorithm, by fitness and population."""
    small, large = sizes.population, sizes.large_population
    kinds: list[tuple[Fitness, int]] = [
        *((fitness, size) for size in (small, large) for fitness in ("-J_k", "-log10 J_k")),
        ("J_d", small),
    ]
    *found, more = search(
        cache,
        *(runs_of(sizes, horizon, j, sizes.runs, is_large=size == large) for j, size in kinds),
        runs_of(sizes, horizon, "-J_k", 2 * sizes.horizon_runs, terms=sizes.more_terms),
    )
    runs = dict(zip(kinds, found, strict=True))
    half = at_half_the_instants(sizes, horizon, runs["J_d", small])
    return Searches(runs, small, more, half)


def check_drake(config: Config, bench: Bench, reference: Motion) -> DrakeCheck:
    """The start of the J_k trajectory on Drake and on the compiled loop, with one noise."""
    setup = bench.setup(config.laboratory, "rich")
    # Which side of a resolver's step a rounding error falls on is chaos: without resolvers.
    setup = dataclasses.replace(setup, sensors=Sensors(), lead_in=0.2, lead_out=0.0)
    part = reference[: max(2, round(config.drake_seconds / PERIOD))]
    fast, drake = (
        runner(setup, part, np.random.default_rng(config.laboratory.seed), runs=1)
        for runner in (run_fast, run_on_drake)
    )
    return DrakeCheck(
        np.array(len(part) * PERIOD + setup.lead_in),
        np.abs(fast.q - drake.q).max(),
        np.abs(fast.command - drake.command).max(),
    )
