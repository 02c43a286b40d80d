"""The paper's binary genetic algorithm (Calafiore 2001, section 3).

Genes by (13)-(14), selection in proportion to fitness, one-point crossover, mutation. The paper
does not state its population, its rates, or how a negative fitness such as -J_k becomes a
probability; all of that is a setting here. Fitness is minus the problem's cost: -log10 J_k, or
J_d, made into a slice of the roulette wheel by Goldberg's linear scaling (1989, "Genetic
Algorithms in Search, Optimization and Machine Learning", p. 76-79).

On the conservative harmonic class (12) every genotype is feasible. On any other class each
variable is coded within its box, and what a genotype stands for is repaired into the limits
before it is evaluated; the genotype itself stays as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.design.optimisers.binary_coding import BinaryCoding
from oed.design.optimisers.problem import Problem
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult, known_digits


@dataclass(frozen=True)
class GeneticSettings:
    """Every choice of the algorithm.

    Attributes:
        bits: Bits of each gene: one number for all (the paper: 4), or one a variable.
        population: Individuals of a generation.
        generations: After which the search ends; None to go on until the budget is spent.
        crossover_rate: Probability that a pair exchanges its tails; else it is copied.
        mutation_rate: Probability of each bit to flip.
        selection_pressure: Expected offspring of the best individual, that of an average
            one being 1 (Goldberg: 1.2 to 2).
        elites: Best individuals that are copied unchanged; 0 for the plain algorithm.
    """

    bits: int | tuple[int, ...] = 4
    population: int = 60
    generations: int | None = None
    crossover_rate: float = 0.8
    mutation_rate: float = 0.02
    selection_pressure: float = 2.0
    elites: int = 1

    def __post_init__(self) -> None:
        if self.population < 2 or not 0 <= self.elites < self.population:
            raise ValueError(f"{self.elites=} of {self.population=}: fewer than all, of 2 or more")
        for rate in (self.crossover_rate, self.mutation_rate):
            if not 0 <= rate <= 1:
                raise ValueError(f"a rate of {rate} is no probability")
        if not self.selection_pressure > 1:
            raise ValueError(f"{self.selection_pressure=} must exceed 1 to prefer the better")


@dataclass(frozen=True)
class Generation:
    """One generation's fitness, for the paper's figure 3.

    Attributes:
        number: From 0, the random population.
        evaluations: Spent when it was complete.
        best_cost: Lowest cost in it.
        mean_cost: Mean of its finite costs.
        best_so_far: Lowest cost of all generations up to it.
    """

    number: int
    evaluations: int
    best_cost: float
    mean_cost: float
    best_so_far: float


def optimise(
    problem: Problem,
    budget: Budget,
    rng: np.random.Generator,
    settings: GeneticSettings | None = None,
) -> OptimiserResult:
    """Minimise by the binary genetic algorithm; see `evolve`."""
    return evolve(problem, budget, rng, settings)[0]


def evolve(
    problem: Problem,
    budget: Budget,
    rng: np.random.Generator,
    settings: GeneticSettings | None = None,
) -> tuple[OptimiserResult, tuple[Generation, ...]]:
    """Minimise by the binary genetic algorithm, and keep the record of its generations.

    Args:
        problem: To be minimised.
        budget: When to stop; the last generation may be incomplete and is then not recorded.
        rng: Source of every draw.
        settings: Rates and sizes.

    Raises:
        ValueError: If `settings.bits` are not one number or one a variable.
    """
    settings = settings or GeneticSettings()
    coding = binary_coding(problem, settings)
    log = EvaluationLog(budget)
    population = coding.random(settings.population, rng)
    generations: list[Generation] = []
    while True:
        costs = _evaluate(problem, coding, population, log)
        if len(costs) < len(population):
            status = f"budget spent in generation {len(generations)}"
            break
        generations.append(_record(len(generations), costs, log))
        if settings.generations is not None and len(generations) > settings.generations:
            status = f"{settings.generations} generations done"
            break
        population = offspring(population, costs, rng, settings)
    if log.best_z is None:
        log.offer(problem.quick_repair(coding.decode(population[0])), np.finfo(float).max)
    return log.result(status), tuple(generations)


def binary_coding(problem: Problem, settings: GeneticSettings) -> BinaryCoding:
    """The coding of a problem's variables."""
    bounds = problem.trajectory.bounds
    bits = settings.bits if isinstance(settings.bits, tuple) else (settings.bits,) * len(bounds)
    return BinaryCoding(bounds, np.array(bits))


def offspring(
    population: Bool[ndarray, "population length"],
    costs: Float[ndarray, " population"],
    rng: np.random.Generator,
    settings: GeneticSettings,
) -> Bool[ndarray, "population length"]:
    """The next generation: elites, then selected pairs, crossed and mutated."""
    size, _ = population.shape
    chances = selection_probabilities(costs, settings.selection_pressure)
    pairs = (size - settings.elites + 1) // 2
    parents = population[roulette(chances, 2 * pairs, rng)]
    children = one_point_crossover(parents[:pairs], parents[pairs:], settings.crossover_rate, rng)
    children ^= rng.random(children.shape) < settings.mutation_rate
    elites = population[np.argsort(costs, kind="stable")[: settings.elites]]
    return np.concatenate([elites, children])[:size]


def selection_probabilities(
    costs: Float[ndarray, " population"], pressure: float
) -> Float[ndarray, " population"]:
    """Slices of the roulette wheel: fitness -cost, scaled linearly.

    The scaling keeps the mean at 1 and gives the best individual `pressure`, unless that would
    make the worst negative; then the worst gets zero. Infinite costs get zero.
    """
    fitness = np.full(len(costs), -np.inf)
    finite = np.isfinite(costs)
    fitness[finite] = -costs[finite]
    if not finite.any() or np.ptp(fitness[finite]) == 0.0:
        share = finite if finite.any() else np.ones(len(costs), dtype=bool)
        return share / share.sum()
    mean, best, worst = fitness[finite].mean(), fitness[finite].max(), fitness[finite].min()
    slope = min((pressure - 1) / (best - mean), 1 / (mean - worst))
    scaled = np.where(finite, 1 + slope * (np.where(finite, fitness, mean) - mean), 0.0)
    scaled = np.maximum(scaled, 0.0)
    return scaled / scaled.sum()


def roulette(
    chances: Float[ndarray, " population"], count: int, rng: np.random.Generator
) -> Int[ndarray, " count"]:
    """Spin the wheel `count` times: indices drawn with replacement."""
    return rng.choice(len(chances), size=count, p=chances)


def one_point_crossover(
    first: Bool[ndarray, "pairs length"],
    second: Bool[ndarray, "pairs length"],
    rate: float,
    rng: np.random.Generator,
) -> Bool[ndarray, "children length"]:
    """Exchange the tails of each pair behind a random bit, with probability `rate`."""
    pairs, length = first.shape
    # A cut behind bit 1 ... length - 1; behind the last bit nothing would be exchanged.
    cuts = rng.integers(1, max(length, 2), size=pairs)
    cuts = np.where(rng.random(pairs) < rate, cuts, length)
    tail = np.arange(length) >= cuts[:, None]
    return np.concatenate([np.where(tail, second, first), np.where(tail, first, second)])


def _evaluate(
    problem: Problem,
    coding: BinaryCoding,
    population: Bool[ndarray, "population length"],
    log: EvaluationLog,
) -> Float[ndarray, " evaluated"]:
    """Costs of the individuals in turn, to their known digits, as far as the budget goes."""
    costs: list[float] = []
    for z in coding.decode(population):
        if log.is_spent:
            break
        costs.append(known_digits(log.evaluate(problem.cost, problem.quick_repair(z))))
    return np.array(costs)


def _record(number: int, costs: Float[ndarray, " population"], log: EvaluationLog) -> Generation:
    finite = costs[np.isfinite(costs)]
    mean = float(finite.mean()) if len(finite) else float("inf")
    return Generation(number, log.evaluations, float(costs.min()), mean, log.best_cost)
