"""A solution is checked independently of its solver, and prices that are not paid count."""

import numpy as np
import pytest

from oed.estimation.feasible.conic_solver import solve_conic
from oed.estimation.feasible.coordinates import ENTRIES, adjoint
from oed.estimation.feasible.optimality import Multipliers, check_optimality
from oed.estimation.feasible.solve import solve_problem
from tests.estimation.feasible.arm_problem import arm_problem


def test_no_feasible_step_goes_down():
    problem = arm_problem(1e-6)
    solution = solve_problem(problem)
    rng = np.random.default_rng(9)
    inner = problem.coordinates.start
    for _ in range(200):
        # Every feasible point is ahead: towards random ones the objective must not fall.
        other = inner + 0.3 * rng.normal(size=len(inner))
        if problem.link_margins(other).min() < problem.margin or problem.slack(other).min() < 0:
            continue
        for step in (1e-6, 1e-4, 1e-2, 1.0):
            between = solution.x + step * (other - solution.x)
            assert problem.objective(between) > solution.objective * (1 - 1e-9)


def test_the_check_does_not_believe_a_wrong_solution():
    problem = arm_problem()
    result = solve_conic(problem)
    assert check_optimality(problem, result.x, result.multipliers).holds()
    other = result.x + 1e-2 * (problem.coordinates.start - result.x)
    assert not check_optimality(problem, other, result.multipliers).holds()
    outside = result.x.copy()
    outside[:10] *= -1e-3
    assert check_optimality(problem, outside, result.multipliers).primal > 1e-4


def test_prices_that_the_point_does_not_pay_widen_the_bound():
    # A pull so strong that the best point is inside all demands, where the objective is a parabola.
    problem = arm_problem(1e2, "quadratic", noise=0.1)
    start = problem.coordinates.start
    hessian = problem.hessian(start)
    best = start - np.linalg.solve(hessian, problem.gradient(start))
    assert problem.link_margins(best).min() > problem.margin
    assert problem.slack(best).min() > 0
    # Prices of demands that do not bind: the Lagrangian's minimum lies elsewhere, and is flat there.
    links = 1e-2 * np.stack([np.eye(4)] * problem.coordinates.links)
    priced = np.zeros(len(best))
    priced[: ENTRIES * problem.coordinates.links] = adjoint(links)
    moved = best + np.linalg.solve(hessian, priced)
    prices = Multipliers(links, np.zeros(len(problem.inequality)))
    found = check_optimality(problem, moved, prices)
    excess = (problem.objective(moved) - problem.objective(best)) / problem.size(moved)
    assert found.decrement < 1e-3 * excess
    assert found.suboptimality >= excess > 0
    assert not found.holds(excess / 2)


def test_derivatives_of_the_objective_agree_with_differences():
    problem = arm_problem()
    rng = np.random.default_rng(10)
    x = problem.coordinates.start
    direction = rng.normal(size=len(x))
    slope = (
        problem.objective(x + 1e-6 * direction) - problem.objective(x - 1e-6 * direction)
    ) / 2e-6
    assert problem.gradient(x) @ direction == pytest.approx(slope, rel=1e-6)
    turn = (problem.gradient(x + 1e-6 * direction) - problem.gradient(x - 1e-6 * direction)) / 2e-6
    assert np.allclose(problem.hessian(x) @ direction, turn, rtol=1e-5, atol=1e-4)


def test_plain_least_squares_is_never_beaten_on_its_own_data():
    problem = arm_problem(1e-8)
    free = np.linalg.lstsq(problem.factor, problem.target, rcond=None)[0]
    assert problem.misfit(solve_problem(problem).x) >= problem.misfit(free) * (1 - 1e-9)
