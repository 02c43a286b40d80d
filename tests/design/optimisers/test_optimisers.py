"""What holds for every optimiser."""

import time

import numpy as np
import pytest

from oed.design.constraints import LimitConstraints
from oed.design.optimisers import evolution, genetic, random_search, slsqp
from oed.design.optimisers.genetic import GeneticSettings
from oed.design.optimisers.random_search import RandomSearchSettings
from oed.design.optimisers.result import Budget, EvaluationLog
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass, HarmonicClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import load_robot
from tests.design.optimisers.toy import Singular, Sphere

BLACK_BOX = {
    "genetic": genetic.optimise,
    "random": random_search.optimise,
    "cma-es": evolution.optimise,
}


@pytest.fixture(scope="module")
def scara() -> dict[str, DesignProblem]:
    robot = load_robot("builtin:imi_scara")
    model = TorqueModel.standard(robot)
    base = base_parameters(model)
    classes = {
        "conservative": HarmonicClass.conservative(robot.limits, 10.0),
        "fourier": FourierClass(10.0, robot.limits, 3),
    }
    return {
        name: DesignProblem(model, base, c, robot.limits, c.instants(40), "J_d", native=False)
        for name, c in classes.items()
    }


@pytest.mark.parametrize("name", BLACK_BOX)
def test_spends_exactly_its_evaluations(name: str) -> None:
    problem = Sphere()
    result = BLACK_BOX[name](problem, Budget(evaluations=137), np.random.default_rng(0))
    assert result.evaluations == len(problem.asked) == 137


@pytest.mark.parametrize("name", BLACK_BOX)
def test_stops_when_its_cpu_time_is_used(name: str) -> None:
    started = time.process_time()
    result = BLACK_BOX[name](Sphere(), Budget(cpu_seconds=0.1), np.random.default_rng(0))
    assert 0.1 <= result.cpu_s < 0.5
    assert time.process_time() - started < 1.0


@pytest.mark.parametrize("name", BLACK_BOX)
def test_the_same_seed_gives_the_same_result(name: str) -> None:
    first, again, other = (
        BLACK_BOX[name](Sphere(), Budget(evaluations=200), np.random.default_rng(seed))
        for seed in (7, 7, 8)
    )
    np.testing.assert_array_equal(first.z, again.z)
    assert [(p.evaluations, p.cost) for p in first.history] == [
        (p.evaluations, p.cost) for p in again.history
    ]
    assert not np.array_equal(first.z, other.z)


@pytest.mark.parametrize("name", BLACK_BOX)
def test_leaves_numpys_global_generator_alone(name: str) -> None:
    np.random.seed(3)  # noqa: NPY002 - that generator is what this test is about
    before = np.random.get_state(legacy=False)["state"]["key"].copy()  # noqa: NPY002
    BLACK_BOX[name](Sphere(), Budget(evaluations=60), np.random.default_rng(0))
    after = np.random.get_state(legacy=False)["state"]["key"]  # noqa: NPY002
    np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize(
    ("name", "within"), [("genetic", 2e-2), ("random", 1e-1), ("cma-es", 1e-4)]
)
def test_finds_a_known_optimum(name: str, within: float) -> None:
    result = BLACK_BOX[name](Sphere(), Budget(evaluations=500), np.random.default_rng(1))
    assert result.cost < within
    assert np.linalg.norm(result.z - Sphere().optimum) ** 2 == pytest.approx(result.cost)


@pytest.mark.parametrize("name", BLACK_BOX)
def test_the_history_is_what_was_evaluated(name: str) -> None:
    problem = Sphere()
    result = BLACK_BOX[name](problem, Budget(evaluations=300), np.random.default_rng(2))
    costs = [((z - problem.optimum) ** 2).sum() for z in problem.asked]
    for point in result.history:
        assert point.cost == pytest.approx(min(costs[: point.evaluations]))
    assert result.history[-1].cost == pytest.approx(min(costs))


@pytest.mark.parametrize("name", BLACK_BOX)
def test_survives_a_problem_without_any_information(name: str) -> None:
    result = BLACK_BOX[name](Singular(), Budget(evaluations=50), np.random.default_rng(0))
    assert len(result.z) == 3
    assert result.cost > 1e300


def test_finer_genes_find_a_finer_optimum() -> None:
    coarse, fine = (
        genetic.optimise(
            Sphere(),
            Budget(evaluations=1200),
            np.random.default_rng(0),
            GeneticSettings(bits=bits, mutation_rate=0.03),
        ).cost
        for bits in (3, 12)
    )
    assert fine < coarse / 3


def test_random_search_may_draw_from_the_box() -> None:
    problem = Sphere()
    settings = RandomSearchSettings(draw="box")
    random_search.optimise(problem, Budget(evaluations=1000), np.random.default_rng(0), settings)
    points = np.array(problem.asked)
    np.testing.assert_allclose(points[:, 0].mean(), 0.5, atol=0.1)
    assert (points[:, 2] == 0.5).mean() == pytest.approx(0.25, abs=0.05)


def test_slsqp_beats_its_starts_within_the_limits(scara: dict[str, DesignProblem]) -> None:
    for problem in scara.values():
        result = slsqp.optimise(problem, Budget(evaluations=60), np.random.default_rng(0))
        assert result.cost < result.history[0].cost - 1.0
        assert problem.certificate(result.z).violation < 1e-9
        assert result.cost == pytest.approx(problem.cost(result.z))


def test_slsqp_keeps_to_its_budget(scara: dict[str, DesignProblem]) -> None:
    problem = scara["fourier"]
    by_count = slsqp.optimise(problem, Budget(evaluations=40), np.random.default_rng(0))
    assert by_count.evaluations == 40
    by_time = slsqp.optimise(problem, Budget(cpu_seconds=0.2), np.random.default_rng(0))
    assert 0.2 <= by_time.cpu_s < 0.6


def test_limit_inequalities_have_the_derivatives_they_claim(
    scara: dict[str, DesignProblem],
) -> None:
    problem = scara["fourier"]
    instants = np.linspace(0.0, problem.trajectory.horizon, 7)
    limits = LimitConstraints(problem.trajectory, problem.limits, instants)
    room, slope = limits.room, limits.room_jacobian
    z = problem.random_start(np.random.default_rng(0))
    step = 1e-6
    for variable in (0, 3, problem.size - 1):
        moved = np.eye(problem.size)[variable] * step
        difference = (room(z + moved) - room(z - moved)) / (2 * step)
        np.testing.assert_allclose(slope(z)[:, variable], difference, atol=1e-7)
    assert (room(z) > -1e-9).all()


def test_the_bound_that_is_reached_first_counts() -> None:
    log = EvaluationLog(Budget(evaluations=3, cpu_seconds=1e6))
    assert not log.is_spent
    log.count(3)
    assert log.is_spent
    assert EvaluationLog(Budget(evaluations=3, cpu_seconds=0.0)).is_spent


def test_a_budget_without_bound_is_refused() -> None:
    with pytest.raises(ValueError, match="budget needs"):
        Budget()
