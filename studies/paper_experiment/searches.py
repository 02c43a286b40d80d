"""Runs of the paper's genetic algorithm: many seeds, both fitnesses, and how T matters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

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
from oed.parallel_map import one_by_one
from oed.report.progress import progress
from oed.robot.builtin import imi_scara
from studies.paper_experiment import values as paper
from studies.paper_experiment.fitness import FITNESSES, Fitness, LinearCondition, criterion_of


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


def search(
    config: DesignConfig,
    horizon: float,
    fitness: Fitness,
    *,
    runs: int,
    terms: int | None = None,
    is_large: bool = False,
) -> Search:
    """Run the paper's genetic algorithm from several seeds."""
    population = config.large_population if is_large else config.population
    settings = genetic.GeneticSettings(
        bits=config.bits,
        population=population,
        generations=config.large_generations if is_large else config.generations,
    )
    terms = terms or config.terms
    spec = problem(paper_class(horizon, terms), criterion_of(fitness), config.samples)
    key = [config.seed, round(1000 * horizon), terms, FITNESSES.index(fitness), population]
    work = partial(_evolve, spec, fitness, settings, key)
    label = f"{fitness}, {population} individuals, W = {terms}, T = {horizon:g} s"
    found = list(progress(one_by_one(work, range(runs)), label, total=runs))
    return Search(*(np.array(part) for part in zip(*found, strict=True)))


def sweep_horizons(config: DesignConfig) -> HorizonTable:
    """Run the genetic algorithm over horizons and seeds."""
    ends: dict[str, list[ndarray]] = {"J_k": [], "J_d": [], "half": []}
    for horizon in config.horizons:
        for fitness in ("-J_k", "J_d"):
            found = search(config, horizon, fitness, runs=config.horizon_runs)
            ends[criterion_of(fitness)].append(found.best[:, -1])
        ends["half"].append(at_half_the_instants(config, horizon, found))
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


def _evolve(
    spec: DesignProblem,
    fitness: Fitness,
    settings: genetic.GeneticSettings,
    key: Sequence[int],
    run: int,
) -> tuple[ndarray, ndarray, ndarray]:
    """End, best so far and mean by generation of one run."""
    budget = Budget(evaluations=((settings.generations or 0) + 2) * settings.population)
    rng = np.random.default_rng([*key, run])
    scored = LinearCondition(spec) if fitness == "-J_k" else spec
    result, generations = genetic.evolve(scored, budget, rng, settings)
    best, mean = (
        np.array([getattr(g, name) for g in generations]) for name in ("best_so_far", "mean_cost")
    )
    if fitness == "J_d":
        return result.z, -best, -mean
    return (result.z, best, mean) if fitness == "-J_k" else (result.z, 10**best, 10**mean)
