from typing import Any

import numpy as np
import pytest
from scipy import stats

from oed.design.optimisers.genetic import (
    GeneticSettings,
    evolve,
    offspring,
    one_point_crossover,
    roulette,
    selection_probabilities,
)
from oed.design.optimisers.result import Budget
from tests.design.optimisers.toy import Box, Sphere


def test_fitness_scaling_gives_the_best_its_expected_offspring() -> None:
    costs = np.array([1.0, 2.0, 2.5, 3.0, 2.2])
    chances = selection_probabilities(costs, 1.5)
    assert chances.sum() == pytest.approx(1.0)
    assert chances[0] * len(costs) == pytest.approx(1.5)
    # Linear: equal steps of fitness are equal steps of probability.
    assert (chances[0] - chances[1]) == pytest.approx(chances[1] - chances[3])


def test_scaling_never_makes_a_chance_negative() -> None:
    chances = selection_probabilities(np.array([0.0, 0.1, 0.1, 0.1, 50.0]), 2.0)
    assert chances.min() == pytest.approx(0.0, abs=1e-15)
    assert chances[0] > chances[1] > chances[4]


def test_singular_motions_are_never_selected() -> None:
    chances = selection_probabilities(np.array([1.0, np.inf, 2.0]), 2.0)
    assert chances[1] == 0.0
    assert selection_probabilities(np.full(4, np.inf), 2.0) == pytest.approx(np.full(4, 0.25))


def test_the_roulette_wheel_turns_in_proportion_to_fitness() -> None:
    chances = selection_probabilities(np.array([1.0, 2.0, 3.0, 4.0]), 1.8)
    drawn = roulette(chances, 20_000, np.random.default_rng(3))
    observed = np.bincount(drawn, minlength=4)
    assert stats.chisquare(observed, 20_000 * chances).pvalue > 0.01


def test_crossover_exchanges_one_tail() -> None:
    first, second = np.zeros((400, 12), dtype=bool), np.ones((400, 12), dtype=bool)
    children = one_point_crossover(first, second, 1.0, np.random.default_rng(1))
    ones, others = children[:400], children[400:]
    np.testing.assert_array_equal(ones, ~others)
    assert (np.diff(ones.astype(int), axis=1) >= 0).all()  # zeros, then the other's tail
    cuts = 12 - ones.sum(axis=1)
    assert set(cuts) == set(range(1, 12))
    assert stats.chisquare(np.bincount(cuts, minlength=12)[1:]).pvalue > 0.01


def test_the_rate_says_how_many_pairs_cross() -> None:
    first, second = np.zeros((4000, 8), dtype=bool), np.ones((4000, 8), dtype=bool)
    children = one_point_crossover(first, second, 0.3, np.random.default_rng(2))
    crossed = children[:4000].any(axis=1).mean()
    assert crossed == pytest.approx(0.3, abs=3 * np.sqrt(0.3 * 0.7 / 4000))


def test_mutation_flips_bits_at_its_rate_and_spares_the_elite() -> None:
    settings = GeneticSettings(crossover_rate=0.0, mutation_rate=0.1, elites=2)
    population = np.zeros((502, 40), dtype=bool)
    children = offspring(population, np.arange(502.0), np.random.default_rng(0), settings)
    assert not children[:2].any()
    rate = children[2:].mean()
    assert rate == pytest.approx(0.1, abs=3 * np.sqrt(0.1 * 0.9 / 20_000))


def test_without_mutation_and_crossover_genes_only_get_selected() -> None:
    settings = GeneticSettings(crossover_rate=0.0, mutation_rate=0.0, elites=0)
    population = np.eye(6, dtype=bool)
    children = offspring(population, np.arange(6.0), np.random.default_rng(0), settings)
    assert {tuple(c) for c in children} <= {tuple(p) for p in population}


def test_records_best_and_mean_of_every_generation() -> None:
    problem = Sphere()
    settings = GeneticSettings(population=20, generations=15, bits=8)
    result, generations = evolve(
        problem, Budget(evaluations=10_000), np.random.default_rng(0), settings
    )
    assert [g.number for g in generations] == list(range(16))
    assert [g.evaluations for g in generations] == list(range(20, 321, 20))
    costs = [problem_cost(problem, z) for z in problem.asked]
    for g in generations:
        of_generation = costs[g.evaluations - 20 : g.evaluations]
        assert g.best_cost == pytest.approx(min(of_generation))
        assert g.mean_cost == pytest.approx(np.mean(of_generation))
        assert g.best_so_far == pytest.approx(min(costs[: g.evaluations]))
    assert result.status == "15 generations done"
    assert generations[-1].mean_cost < generations[0].mean_cost


def problem_cost(problem: Sphere, z: np.ndarray) -> float:
    return float(((z - problem.optimum) ** 2).sum())


def test_an_elite_is_never_lost() -> None:
    settings = GeneticSettings(population=10, elites=1, mutation_rate=0.2)
    _, generations = evolve(Sphere(), Budget(evaluations=400), np.random.default_rng(5), settings)
    best = [g.best_cost for g in generations]
    assert best == sorted(best, reverse=True)


class Mirrored(Sphere):
    """Costs the same at z and -z but for rounding, as a motion and its mirror image."""

    def __init__(self, rounding: float) -> None:
        super().__init__(Box(np.tile([-1.0, 1.0], (3, 1))))
        self.rounding = rounding

    def quick_repair(self, z: np.ndarray) -> np.ndarray:
        return z

    def cost(self, z: np.ndarray) -> float:
        self.asked.append(z)
        return float((np.abs(z) - 0.4) @ (np.abs(z) - 0.4)) * (1 + self.rounding * np.sin(z.sum()))


def test_the_last_digit_of_a_sum_does_not_choose_among_mirror_images() -> None:
    runs = [Mirrored(rounding) for rounding in (0.0, 1e-14, -1e-14)]
    ends = [
        evolve(p, Budget(evaluations=1200), np.random.default_rng(4), GeneticSettings())[0].z
        for p in runs
    ]
    for other, end in zip(runs[1:], ends[1:], strict=True):
        assert np.array_equal(runs[0].asked, other.asked)
        assert np.array_equal(ends[0], end)


def test_what_is_evaluated_is_feasible_even_where_the_box_is_not() -> None:
    problem = Sphere()
    evolve(problem, Budget(evaluations=300), np.random.default_rng(0), GeneticSettings())
    assert max(z[2] for z in problem.asked) <= 0.5


@pytest.mark.parametrize(
    "wrong",
    [
        {"population": 1},
        {"elites": 60},
        {"mutation_rate": 1.5},
        {"crossover_rate": -0.1},
        {"selection_pressure": 1.0},
    ],
)
def test_refuses_settings_that_make_no_sense(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - each setting has its own message
        GeneticSettings(**wrong)
