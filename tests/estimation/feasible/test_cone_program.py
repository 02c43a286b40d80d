"""Both conic solvers find answers that are known, with the prices of their cones."""

import numpy as np
import pytest

from oed.estimation.feasible.cone_program import (
    ConeProgram,
    ConeRows,
    ConicSolver,
    SolverFailed,
    solve_cones,
)

SETTINGS: dict[ConicSolver, dict[str, float]] = {
    "clarabel": {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10},
    "scs": {"eps_abs": 1e-9, "eps_rel": 1e-9},
}
SOLVERS: tuple[ConicSolver, ...] = ("clarabel", "scs")


def coordinates(matrix):
    """Of a symmetric matrix: its upper triangle row by row, off the diagonal times sqrt 2."""
    row, column = np.triu_indices(len(matrix))
    return matrix[row, column] * np.where(row == column, 1.0, np.sqrt(2))


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_nearest_semidefinite_matrices_are_those_without_negative_eigenvalues(solver):
    rng = np.random.default_rng(21)
    orders = (4, 2, 3)
    given = [matrix + matrix.T for matrix in (rng.normal(size=(k, k)) for k in orders)]
    wanted = np.concatenate([coordinates(matrix) for matrix in given])
    count = len(wanted)
    program = ConeProgram(
        quadratic=np.ones(count),
        linear=-wanted,
        zero=ConeRows.none(count),
        nonnegative=ConeRows.none(count),
        semidefinite=ConeRows(-np.eye(count), np.zeros(count)),
        orders=orders,
        exponential=ConeRows.none(count),
    )
    found = solve_cones(program, solver, SETTINGS[solver])
    nearest = [_share(matrix, 1.0) for matrix in given]
    assert found.x == pytest.approx(np.concatenate(nearest), abs=1e-6)
    # Moreau: what is taken away is the price.
    prices = np.concatenate([_share(matrix, -1.0) for matrix in given])
    assert found.semidefinite == pytest.approx(prices, abs=1e-6)
    assert found.is_solved


def _share(matrix, sign):
    """Coordinates of the part of a matrix with eigenvalues of one sign, made positive."""
    values, vectors = np.linalg.eigh(matrix)
    return coordinates((vectors * np.maximum(sign * values, 0.0)) @ vectors.T)


@pytest.mark.parametrize("solver", SOLVERS)
def test_logarithms_under_a_budget_share_it_by_their_weights(solver):
    weights, budget = np.array([1.0, 2.0, 5.0]), 4.0
    # Variables: three amounts, their logarithms, and one that an equation holds.
    exponential = np.zeros((9, 7))
    exponential[[0, 3, 6], [3, 4, 5]] = -1.0
    exponential[[2, 5, 8], [0, 1, 2]] = -1.0
    program = ConeProgram(
        quadratic=np.zeros(7),
        linear=np.concatenate([np.zeros(3), -weights, [0.0]]),
        zero=ConeRows(np.eye(7)[-1:], np.array([0.5])),
        nonnegative=ConeRows(np.array([[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]]), np.array([budget])),
        semidefinite=ConeRows.none(7),
        orders=(),
        exponential=ConeRows(exponential, np.tile([0.0, 1.0, 0.0], 3)),
    )
    found = solve_cones(program, solver, SETTINGS[solver])
    shares = (budget - 0.5) * weights / weights.sum()
    # The objective is flat there: ten digits of it are five of the shares.
    assert found.x == pytest.approx(np.concatenate([shares, np.log(shares), [0.5]]), abs=1e-4)
    # One more of the budget is worth the weights' sum over what there is of it.
    assert found.nonnegative == pytest.approx([weights.sum() / (budget - 0.5)], rel=1e-5)


@pytest.mark.parametrize("solver", SOLVERS)
def test_demands_that_nothing_meets_are_a_failure_in_the_solvers_words(solver):
    program = ConeProgram(
        quadratic=np.zeros(1),
        linear=np.ones(1),
        zero=ConeRows.none(1),
        nonnegative=ConeRows(np.array([[1.0], [-1.0]]), np.array([0.0, -1.0])),
        semidefinite=ConeRows.none(1),
        orders=(),
        exponential=ConeRows.none(1),
    )
    with pytest.raises(SolverFailed, match=r"(?i)infeasible") as caught:
        solve_cones(program, solver, SETTINGS[solver])
    assert caught.value.attempts[0].startswith(f"{solver}: ")


def test_a_point_that_the_limit_of_steps_stopped_at_is_no_solution():
    count = 3
    program = ConeProgram(
        quadratic=np.ones(count),
        linear=np.array([1.0, -2.0, 1.0]),
        zero=ConeRows.none(count),
        nonnegative=ConeRows(-np.eye(count), np.zeros(count)),
        semidefinite=ConeRows.none(count),
        orders=(),
        exponential=ConeRows.none(count),
    )
    assert not solve_cones(program, "clarabel", {"max_iter": 1}).is_solved
    assert solve_cones(program, "clarabel", {}).is_solved
