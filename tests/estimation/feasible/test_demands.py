"""Demands that contradict each other, or the prior, are named and proven."""

import numpy as np
import pytest
from scipy.linalg import null_space

from oed.estimation.feasible.barrier_solver import solve_barrier
from oed.estimation.feasible.estimate import estimate_feasible
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.reference import (
    InfeasiblePrior,
)
from oed.estimation.feasible.regularisation import Regularisation
from oed.estimation.feasible.solve import ContradictoryDemands, solve_problem
from tests.estimation.feasible.arm_problem import arm_problem
from tests.estimation.feasible.cases import data_of, small_model, true_parameters


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


def test_demands_that_leave_too_little_room_are_not_said_to_be_missed():
    problem = arm_problem(total_mass=1e-9)
    with pytest.raises(ContradictoryDemands) as caught:
        solve_problem(problem)
    assert 0 <= caught.value.margin < problem.margin
    told = str(caught.value)
    assert "missed" not in told
    assert f"they leave {caught.value.margin:.2g} of the reference bodies" in told


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
