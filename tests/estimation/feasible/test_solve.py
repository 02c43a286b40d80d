"""Independent solvers agree, and find answers that are known."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.identifiability import base_parameters
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.estimation.feasible import solve
from oed.estimation.feasible.barrier_solver import solve_barrier
from oed.estimation.feasible.conic_solver import solve_conic
from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.estimate import estimate_feasible
from oed.estimation.feasible.feasible_set import FeasibleSet, MassRegion
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.problem import build_problem
from oed.estimation.feasible.reference import (
    neutral_bodies,
    scaled_neutral_bodies,
)
from oed.estimation.feasible.regularisation import Regularisation
from oed.estimation.feasible.solve import solve_problem
from oed.robot import load_robot
from tests.estimation.feasible.arm_problem import arm_problem
from tests.estimation.feasible.cases import data_of, random_tree, small_model, true_parameters
from tests.paths import example_robot


@pytest.mark.parametrize("kind", ["entropic", "quadratic"])
@pytest.mark.parametrize("weight", [1e-6, 1e-2])
def test_two_solvers_agree(weight, kind):
    problem = arm_problem(weight, kind)
    conic, barrier = (solve_problem(problem, (name,)) for name in ("clarabel", "barrier"))
    assert conic.objective == pytest.approx(barrier.objective, rel=1e-6)


def test_solvers_agree_under_all_kinds_of_demands():
    wide = MassRegion.box(1, -0.6 * np.ones(3), 0.6 * np.ones(3))
    narrow = MassRegion.box(2, -0.2 * np.ones(3), 0.2 * np.ones(3))
    problem = arm_problem(total_mass=6.0, known_masses={2: 1.5}, regions=(wide, narrow))
    conic, barrier = (solve_problem(problem, (name,)) for name in ("clarabel", "barrier"))
    assert conic.objective == pytest.approx(barrier.objective, rel=1e-6)
    parameters = problem.coordinates.parameters(conic.x)
    assert parameters[:30:10].sum() == pytest.approx(6.0)
    assert parameters[20] == pytest.approx(1.5)
    assert problem.slack(conic.x).min() > -1e-9


def test_a_third_solver_agrees_on_a_small_arm():
    rng = np.random.default_rng(8)
    model = build_model("standard", random_tree(2, rng))
    data = data_of(model, true_parameters(model, rng), rng, noise=1.0)
    problem = build_problem(
        model,
        data,
        FeasibleSet.of(model),
        scaled_neutral_bodies(model.robot, data.factor, data.target),
        Regularisation(1e-2),
    )
    scs = problem.objective(solve_conic(problem, "scs").x)
    assert scs == pytest.approx(solve_problem(problem).objective, rel=1e-6)


def test_a_truth_inside_the_set_is_recovered_without_noise():
    rng = np.random.default_rng(11)
    model = small_model()
    truth = true_parameters(model, rng)
    estimate = estimate_feasible(
        model, data_of(model, truth, rng), regularisation=Regularisation(1e-10)
    )
    base = base_parameters(model)
    found, true = (base.from_standard(p) for p in (estimate.parameters, truth))
    assert np.abs(found - true).max() < 1e-5 * np.abs(true).max()
    assert estimate.relative_margins.min() > 0
    assert estimate.active == ()


def test_without_data_on_a_parameter_it_is_the_references():
    rng = np.random.default_rng(12)
    model = small_model()
    prior = model.robot.parameters
    estimate = estimate_feasible(
        model,
        data_of(model, true_parameters(model, rng), rng),
        prior=prior,
        regularisation=Regularisation(1e-6),
    )
    # No torque depends on the mass of the first link: its joint axis stands still.
    assert estimate.from_data[0] < 1e-6
    assert estimate.parameters[0] == pytest.approx(prior[0], rel=1e-3)


def test_a_solver_that_fails_is_reported_and_the_next_is_tried(monkeypatch):
    problem = arm_problem()
    broken = dataclasses.replace(problem, margin=problem.margin)

    def fail(problem, solver, at=None):
        raise SolverFailed("no solution", ("clarabel: made to fail",))

    monkeypatch.setattr(solve, "solve_conic", fail)
    solution = solve_problem(broken)
    assert solution.solver == "barrier"
    assert solution.attempts[0] == "clarabel: made to fail"
    with pytest.raises(SolverFailed, match="made to fail"):
        solve_problem(broken, ("clarabel",))


def test_a_seven_joint_arm_is_solved_in_a_size_that_no_sample_adds_to():
    robot = load_robot(
        example_robot("panda_description/urdf/panda.urdf"),
        joints=[f"panda_joint{i}" for i in range(1, 8)],
    )
    model = build_model("rotor", robot)
    rng = np.random.default_rng(14)
    truth = true_parameters(model, rng)
    assert len(truth) == 91
    for samples in (100, 5000):
        data = data_of(model, truth, rng, samples=samples, noise=1.0)
        assert data.triangle.shape == (92, 92)
        estimate = estimate_feasible(model, data, regularisation=Regularisation(1e-4))
        assert estimate.solution.is_accurate


def test_a_tree_of_thirty_links_is_solved():
    rng = np.random.default_rng(15)
    model = build_model("standard", random_tree(30, rng))
    data = data_of(model, true_parameters(model, rng), rng, samples=100, noise=1.0)
    estimate = estimate_feasible(model, data, regularisation=Regularisation(1e-4))
    assert estimate.solution.is_accurate
    assert estimate.relative_margins.min() >= estimate.problem.margin * (1 - 1e-6)


def poor_problem(weight):
    """A motion too small to tell its masses: they are hundreds of times those of the reference."""
    rng = np.random.default_rng(16)
    model = small_model()
    motion = Motion(np.arange(60.0), *(0.02 * rng.standard_normal((3, 60, 3))))
    regressor = model.regressor(motion)
    torque = rng.standard_normal((60, 3))
    data = DataFactor.of(regressor, torque, np.full(3, 0.01))
    return build_problem(
        model,
        data,
        FeasibleSet.of(model),
        neutral_bodies(model.robot),
        Regularisation(weight),
    )


@pytest.mark.parametrize("weight", [1e-8, 1e-6, 1e-4])
def test_data_that_hardly_tell_the_masses_are_solved_all_the_same(weight):
    problem = poor_problem(weight)
    conic, barrier = (solve_problem(problem, (name,)) for name in ("clarabel", "barrier"))
    assert conic.is_accurate
    assert barrier.is_accurate
    assert conic.objective == pytest.approx(barrier.objective, rel=1e-7)
    if weight < 1e-7:
        assert problem.coordinates.relative_inertias(conic.x).max() > 100


def test_there_is_an_estimate_with_the_accuracy_that_it_reached():
    problem = arm_problem()
    best = solve_problem(problem)
    asked_too_much = solve_problem(problem, tolerance=0.0)
    assert not asked_too_much.is_accurate
    assert "where 0e+00 was asked for" in asked_too_much.accuracy
    assert "all demands are met" in asked_too_much.accuracy
    # What it says of itself holds against the other solver's optimum.
    reached = asked_too_much.optimality.suboptimality
    assert 0 < reached < 1e-6
    lowest = min(best.objective, problem.objective(solve_barrier(problem).x))
    assert asked_too_much.objective <= lowest * (1 + reached + 1e-9)
    assert len(asked_too_much.attempts) == 3


def test_a_point_outside_is_drawn_inside_and_says_so(monkeypatch):
    problem = arm_problem(total_mass=6.0)
    outside = solve_conic(problem)
    wrong = dataclasses.replace(outside, x=outside.x * (1 + 1e-3))
    monkeypatch.setattr(solve, "solve_conic", lambda problem, solver, at=None: wrong)
    found = solve_problem(problem, ("clarabel",))
    assert found.optimality.primal <= 1e-9
    assert problem.link_margins(found.x).min() >= problem.margin * (1 - 1e-5)
    assert not found.is_accurate
    assert found.objective > solve_problem(problem, ("barrier",)).objective


def test_neutral_bodies_are_consistent_for_any_arm():
    for joints in (1, 4, 12):
        robot = random_tree(joints, np.random.default_rng(joints))
        model = build_model("standard", robot)
        assert len(neutral_bodies(robot)) == 10 * joints
        assert FeasibleSet.of(model).margin > 0
