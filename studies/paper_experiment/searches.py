"""Runs of the paper's genetic algorithm: many seeds, both fitnesses, and how T matters."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import Criterion
from oed.design.optimisers import genetic
from oed.design.optimisers.result import Budget
from oed.design.problem import DesignProblem
from oed.design.trajectories.harmonic import HarmonicClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot.builtin import imi_scara
from studies.case_runner import Outcome
from studies.paper_experiment import values as paper
from studies.paper_experiment.fitness import FITNESSES, Fitness, LinearCondition, criterion_of
from studies.paper_experiment.stage_cache import StageCache, packed


@dataclass(frozen=True)
class DesignConfig:
    """How the trajectories are designed.

    Attributes:
        horizons: The paper does not state T; these are tried [s].
        samples: Instants of the criterion, and of every repetition.
        terms: W.
        more_terms: W that is tried beside the paper's.
        bits: Of each gene.
        population: Of the genetic algorithm, which the paper does not state.
        generations: Of the genetic algorithm: J_d, the slower, ends at the same value from most
            starts by then.
        large_population: Tried beside it.
        large_generations: Of that, for about as many evaluations.
        runs: Seeds of the genetic algorithm.
        horizon_runs: Seeds at each horizon, and with more terms.
        pairs: Seeds, the first of `runs`, whose designs are run on the arm.
        tests: Test trajectories.
        exact_evaluations: Of each design under exact limits.
        seed: Of every draw here.
    """

    horizons: tuple[float, ...] = (4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
    samples: int = 80
    terms: int = 3
    more_terms: int = 5
    bits: int = 4
    population: int = 60
    generations: int = 160
    large_population: int = 200
    large_generations: int = 40
    runs: int = 30
    horizon_runs: int = 6
    pairs: int = 20
    tests: int = 12
    exact_evaluations: int = 600
    seed: int = 2001


@dataclass(frozen=True)
class Search:
    """Runs of the genetic algorithm that differ in their seed alone.

    Attributes:
        z: (R, size) where each ended.
        best: (R, G + 1) best J_k or J_d up to each generation.
        mean: (R, G + 1) mean of each generation: J_k geometric where its logarithm is evolved.
    """

    z: Float[ndarray, "R size"]
    best: Float[ndarray, "R generations"]
    mean: Float[ndarray, "R generations"]

    @property
    def generations(self) -> int:
        """G."""
        return self.best.shape[1] - 1

    @classmethod
    def joined(cls, parts: Sequence[Search]) -> Search:
        """The runs of several."""
        return cls(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(cls)))


@dataclass(frozen=True)
class Searches:
    """All runs of the algorithm at the horizon that is used.

    Attributes:
        runs: By fitness and population.
        population: Of the runs whose designs are used.
        more_terms: With more sines a joint.
        half: (R,) J_d of the J_d runs' ends with half as many instants.
    """

    runs: dict[tuple[Fitness, int], Search]
    population: int
    more_terms: Search
    half: Float[ndarray, " R"]

    @property
    def condition(self) -> Search:
        """The paper's, for J_k."""
        return self.runs["-J_k", self.population]

    @property
    def determinant(self) -> Search:
        """The paper's, for J_d."""
        return self.runs["J_d", self.population]


@dataclass(frozen=True)
class HorizonTable:
    """What the genetic algorithm reaches, by horizon and seed.

    Attributes:
        horizon: (H,) [s].
        J_k: (H, R) cond Lambda.
        J_d: (H, R) log10 det Lambda at `samples` instants.
        J_d_half: (H, R) the same motion at half as many instants.
        chosen: () the horizon whose median J_k is nearest to the paper's [s].
    """

    horizon: Float[ndarray, " H"]
    J_k: Float[ndarray, "H R"]
    J_d: Float[ndarray, "H R"]
    J_d_half: Float[ndarray, "H R"]
    chosen: ndarray


def paper_class(horizon: float, terms: int) -> HarmonicClass:
    """Sums of sines under the paper's conservative limits (12)."""
    return HarmonicClass.conservative(imi_scara().limits, horizon, terms)


def problem(trajectory: HarmonicClass, criterion: Criterion, samples: int) -> DesignProblem:
    """The paper's problem: R_v = I while the trajectory is designed."""
    robot = imi_scara()
    model = TorqueModel.standard(robot)
    instants = trajectory.instants(samples)
    base = base_parameters(model)
    return DesignProblem(model, base, trajectory, robot.limits, instants, criterion)


@dataclass(frozen=True)
class SearchRun:
    """One run of the genetic algorithm.

    Attributes:
        fitness: What it evolves.
        settings: Of the algorithm.
        terms: W.
        horizon: T [s].
        samples: Instants of the criterion.
        seed: Of all runs.
        run: Which; with the rest it decides what is drawn.
    """

    fitness: Fitness
    settings: genetic.GeneticSettings
    terms: int
    horizon: float
    samples: int
    seed: int
    run: int

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with, see `KEY`."""
        numbers = (self.settings.population, self.terms, self.horizon, self.run)
        return (self.fitness, *map(str, numbers))


KEY = ("fitness", "population", "terms", "horizon", "run")


def runs_of(
    config: DesignConfig,
    horizon: float,
    fitness: Fitness,
    runs: int,
    *,
    terms: int | None = None,
    is_large: bool = False,
) -> list[SearchRun]:
    """The paper's genetic algorithm from several seeds."""
    settings = genetic.GeneticSettings(
        bits=config.bits,
        population=config.large_population if is_large else config.population,
        generations=config.large_generations if is_large else config.generations,
    )
    common = (fitness, settings, terms or config.terms, horizon, config.samples, config.seed)
    return [SearchRun(*common, run) for run in range(runs)]


def search(cache: StageCache, *searches: Sequence[SearchRun]) -> list[Search]:
    """All runs of some searches, side by side."""
    runs = [run for own in searches for run in own]
    found = iter(cache.each("searches", KEY, evolve, runs))
    return [Search.joined([Search(**next(found)) for _ in own]) for own in searches]


def sweep_horizons(config: DesignConfig, cache: StageCache) -> HorizonTable:
    """Run the genetic algorithm over horizons and seeds."""
    kinds: tuple[Fitness, Fitness] = ("-J_k", "J_d")
    places = list(itertools.product(config.horizons, kinds))
    found = search(cache, *(runs_of(config, *place, config.horizon_runs) for place in places))
    ends: dict[str, list[ndarray]] = {"J_k": [], "J_d": [], "half": []}
    for (horizon, fitness), own in zip(places, found, strict=True):
        ends[criterion_of(fitness)].append(own.best[:, -1])
        if fitness == "J_d":
            ends["half"].append(at_half_the_instants(config, horizon, own))
    J_k, J_d, half = (np.array(values) for values in ends.values())
    distance = np.abs(np.log(np.median(J_k, axis=1) / paper.J_K))
    horizons = np.array(config.horizons)
    return HorizonTable(horizons, J_k, J_d, half, horizons[np.argmin(distance)])


def at_half_the_instants(
    config: DesignConfig, horizon: float, found: Search
) -> Float[ndarray, " R"]:
    """J_d of the ends of a search, with half as many instants."""
    spec = problem(paper_class(horizon, config.terms), "J_d", config.samples // 2)
    return np.array([-spec.cost(z) for z in found.z])


def evolve(one: SearchRun) -> Outcome:
    """End, best so far and mean by generation, as a `Search` of one run."""
    spec = problem(paper_class(one.horizon, one.terms), criterion_of(one.fitness), one.samples)
    population = one.settings.population
    budget = Budget(evaluations=((one.settings.generations or 0) + 2) * population)
    kind = FITNESSES.index(one.fitness)
    key = [one.seed, round(1000 * one.horizon), one.terms, kind, population, one.run]
    scored = LinearCondition(spec) if one.fitness == "-J_k" else spec
    rng = np.random.default_rng(key)
    result, generations = genetic.evolve(scored, budget, rng, one.settings)
    best, mean = (
        np.array([getattr(g, name) for g in generations]) for name in ("best_so_far", "mean_cost")
    )
    if one.fitness == "J_d":
        best, mean = -best, -mean
    elif one.fitness == "-log10 J_k":
        best, mean = 10**best, 10**mean
    return packed({"z": result.z[None], "best": best[None], "mean": mean[None]})
