"""The conic program is the problem, as a modelling language takes it from its own words."""

import numpy as np
import pytest

from oed.estimation.feasible import interior
from oed.estimation.feasible.cone_program import SolverFailed, solve_cones
from oed.estimation.feasible.conic_solver import solve_conic
from oed.estimation.feasible.coordinates import BASIS, ENTRIES, IDENTITY
from oed.estimation.feasible.feasible_set import MassRegion
from oed.estimation.feasible.interior import most_interior
from oed.estimation.feasible.regularisation import quadratic_root
from tests.estimation.feasible.arm_problem import arm_problem

ACCURATE = {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10}


def demanding_problem(kind, weight):
    box = MassRegion.box(1, -0.15 * np.ones(3), 0.15 * np.ones(3))
    return arm_problem(
        weight, kind, total_mass=6.0, known_masses={2: 1.5}, regions=(box,), margin=0.2
    )


def in_its_own_words(problem):
    """Objective, point and prices by CVXPY."""
    cp = pytest.importorskip("cvxpy")
    coordinates, inertial = problem.coordinates, ENTRIES * problem.coordinates.links
    x = cp.Variable(coordinates.size)
    bodies = [
        cp.reshape(BASIS.reshape(ENTRIES, 16).T @ x[k : k + ENTRIES], (4, 4), order="C")
        for k in range(0, inertial, ENTRIES)
    ]
    if problem.regularisation.kind == "entropic":
        distance = np.tile(IDENTITY, len(bodies)) @ x[:inertial] - 4 * len(bodies)
        distance -= sum(cp.log_det(body) for body in bodies)
    else:
        distance = cp.sum_squares(quadratic_root(coordinates) @ (x - coordinates.start)) / 2
    objective = cp.sum_squares(problem.factor @ x - problem.target) + problem.constant
    objective += cp.sum_squares(cp.multiply(np.sqrt(problem.tie_break / 2), x))
    links = [body >> problem.margin * np.eye(4) for body in bodies]
    rows = problem.inequality.matrix @ x >= problem.inequality.bound
    equal = problem.equality.matrix @ x == problem.equality.bound
    program = cp.Problem(
        cp.Minimize(objective + problem.regularisation.weight * distance), [*links, rows, equal]
    )
    program.solve(solver="CLARABEL", **ACCURATE)
    return program.value, x.value, np.array([link.dual_value for link in links]), rows.dual_value


@pytest.mark.parametrize("measured", ["at the reference", "at a point"])
@pytest.mark.parametrize(("kind", "weight"), [("entropic", 1e-4), ("quadratic", 1e-1)])
def test_point_and_prices_are_those_of_the_problem_in_its_own_words(kind, weight, measured):
    problem = demanding_problem(kind, weight)
    value, x, links, rows = in_its_own_words(problem)
    at = most_interior(problem.coordinates, problem.inequality, problem.equality).x
    found = solve_conic(problem, at=at if measured == "at a point" else None)
    assert problem.objective(found.x) == pytest.approx(value, rel=1e-8)
    assert found.x == pytest.approx(x, abs=1e-4 * np.abs(x).max())
    # Some demand of each kind binds: a price of zero would be no evidence.
    assert rows.max() > 1e-4
    assert found.multipliers.inequality == pytest.approx(rows, abs=1e-5 * rows.max())
    assert np.abs(links).max() > 1e-4
    assert found.multipliers.links == pytest.approx(links, abs=1e-4 * np.abs(links).max())


@pytest.mark.parametrize("first", ["fails", "stops"])
def test_the_second_solver_finds_the_same_interior_where_the_first_does_not(monkeypatch, first):
    problem = arm_problem(total_mass=3.0, known_masses={1: 2.0, 2: 1.5})
    demands = (problem.coordinates, problem.inequality, problem.equality)
    expected = most_interior(*demands)

    def hampered(program, solver, settings):
        if solver == "clarabel" and first == "fails":
            raise SolverFailed("no solution", ("clarabel: made to fail",))
        return solve_cones(program, solver, {"max_iter": 1} if solver == "clarabel" else settings)

    monkeypatch.setattr(interior, "solve_cones", hampered)
    found = most_interior(*demands)
    assert found.margin == pytest.approx(expected.margin, abs=1e-3)
    assert found.certificate.bound == pytest.approx(expected.certificate.bound, abs=1e-3)
    assert found.certificate.residual < 1e-3
