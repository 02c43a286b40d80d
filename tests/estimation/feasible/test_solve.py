"""Independent solvers, independent checks, and answers that are known."""

import dataclasses
import time

import numpy as np
import pytest
from scipy.linalg import null_space

from oed.dynamics.identifiability import base_parameters
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.estimation.feasible import solve
from oed.estimation.feasible.barrier_solver import solve_barrier
from oed.estimation.feasible.conic_solver import solve_conic
from oed.estimation.feasible.coordinates import ENTRIES, adjoint
from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.estimate import estimate_feasible
from oed.estimation.feasible.feasible_set import FeasibleSet, MassRegion
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.optimality import Multipliers, check_optimality
from oed.estimation.feasible.problem import build_problem
from oed.estimation.feasible.reference import (
    InfeasiblePrior,
    neutral_bodies,
    scaled_neutral_bodies,
)
from oed.estimation.feasible.regularisation import Regularisation, RegularisationKind
from oed.estimation.feasible.solve import ContradictoryDemands, solve_problem
from oed.robot import load_robot
from tests.estimation.feasible.cases import data_of, random_tree, small_model, true_parameters
from tests.paths import example_robot


def arm_problem(weight=1e-4, kind: RegularisationKind = "entropic", noise=2.0, **demands):
    rng = np.random.default_rng(7)
    model = small_model()
    data = data_of(model, true_parameters(model, rng), rng, noise=noise, samples=40)
    reference = scaled_neutral_bodies(model.robot, data.factor, data.target)
    wanted = FeasibleSet.of(model).with_(**demands)
    return build_problem(model, data, wanted, reference, Regularisation(weight, kind))


@pytest.mark.parametrize("kind", ["entropic", "quadratic"])
@pytest.mark.parametrize("weight", [1e-6, 1e-2])
def test_two_solvers_agree(weight, kind):
    problem = arm_problem(weight, kind)
    conic, barrier = (solve_problem(problem, (name,)) for name in ("clarabel", "barrier"))
    assert conic.objective == pytest.approx(barrier.objective, rel=1e-6)


def test_solvers_agree_under_all_kinds_of_demands():
    box = MassRegion.box(1, -0.6 * np.ones(3), 0.6 * np.ones(3))
    ball = MassRegion.ellipsoid(2, np.zeros(3), 0.04 * np.eye(3))
    problem = arm_problem(total_mass=6.0, known_masses={2: 1.5}, regions=(box, ball))
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


def test_plain_least_squares_is_never_beaten_on_its_own_data():
    problem = arm_problem(1e-8)
    free = np.linalg.lstsq(problem.factor, problem.target, rcond=None)[0]
    assert problem.misfit(solve_problem(problem).x) >= problem.misfit(free) * (1 - 1e-9)


def test_an_infeasible_prior_is_named():
    model = small_model()
    prior = model.robot.parameters.copy()
    prior[2 * 10 + 4] *= -1.0
    rng = np.random.default_rng(13)
    with pytest.raises(InfeasiblePrior, match=model.robot.joints[2].link) as caught:
        estimate_feasible(
            model,
            data_of(model, true_parameters(model, rng), rng),
            prior=prior,
            regularisation=Regularisation(1.0),
        )
    assert caught.value.links == (2,)
    assert caught.value.margins[2] < 0


def test_contradictory_masses_are_named():
    problem = arm_problem(total_mass=3.0, known_masses={1: 2.0, 2: 1.5})
    with pytest.raises(ContradictoryDemands) as caught:
        solve_problem(problem)
    assert "total mass = 3 kg" in caught.value.demands
    assert any("mass of" in name and "= 2 kg" in name for name in caught.value.demands)
    assert caught.value.margin < 0


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


def test_a_seven_joint_arm_takes_less_than_two_seconds_whatever_the_samples():
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
        start = time.process_time()
        estimate_feasible(model, data, regularisation=Regularisation(1e-4))
        assert time.process_time() - start < 2.0


def test_a_tree_of_thirty_links_takes_less_than_twenty_seconds():
    rng = np.random.default_rng(15)
    model = build_model("standard", random_tree(30, rng))
    data = data_of(model, true_parameters(model, rng), rng, samples=100, noise=1.0)
    start = time.process_time()
    estimate = estimate_feasible(model, data, regularisation=Regularisation(1e-4))
    assert time.process_time() - start < 20.0
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


def test_a_certificate_is_checked_by_its_eigenvalues():
    problem = arm_problem(total_mass=3.0, known_masses={1: 2.0, 2: 1.5})
    with pytest.raises(ContradictoryDemands) as caught:
        solve_problem(problem)
    proof = caught.value.certificate
    assert np.linalg.eigvalsh(proof.matrices).min() >= -1e-12
    assert proof.inequality.min(initial=0.0) >= 0
    # For points that obey the equalities the weighted demands add up to the bound: below zero.
    free = null_space(problem.equality.matrix)
    some = np.linalg.lstsq(problem.equality.matrix, problem.equality.bound, rcond=None)[0]
    rng = np.random.default_rng(17)
    for _ in range(5):
        x = some + free @ rng.standard_normal(free.shape[1])
        inertias = problem.coordinates.relative_inertias(x)
        weighted = np.sum(proof.matrices * inertias) + proof.inequality @ problem.slack(x)
        assert weighted == pytest.approx(proof.bound, abs=1e-5)
    assert proof.bound < 0


def test_barrier_needs_a_strict_interior():
    problem = arm_problem(total_mass=1e-9)
    with pytest.raises(SolverFailed, match="strictly feasible"):
        solve_barrier(problem)


def test_neutral_bodies_are_consistent_for_any_arm():
    for joints in (1, 4, 12):
        robot = random_tree(joints, np.random.default_rng(joints))
        model = build_model("standard", robot)
        assert len(neutral_bodies(robot)) == 10 * joints
        assert FeasibleSet.of(model).margin > 0
