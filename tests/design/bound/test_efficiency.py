"""What a design file says of D-efficiency."""

import dataclasses

import numpy as np
import pytest

from oed.design.bound.efficiency import QUICK, Effort, NoBound, d_efficiency
from oed.design.bound.estimated_bound import SearchSettings, estimated_bound
from oed.design.bound.information_bound import BoundSettings, information_bound
from oed.design.design import Design
from oed.design.optimisers import slsqp
from oed.design.optimisers.result import Budget
from oed.design.trajectories import FourierClass
from tests.design.problems import HORIZON, paper_problem, scara

FEW = SearchSettings(first_states=20, rounds=1, candidates=10, kept=5, sweeps=1, last_steps=5)


@pytest.fixture(scope="module")
def design() -> Design:
    problem = paper_problem(FourierClass(HORIZON, scara()[0].limits), native=False)
    result = slsqp.optimise(problem, Budget(evaluations=60), np.random.default_rng(0))
    return Design.from_result(problem, result)


def test_the_estimate_agrees_with_the_proof_of_the_same_relaxation(design: Design) -> None:
    robot, model, base = scara()
    settings = BoundSettings(degree=2, first_atoms=1000, states_per_round=4000)
    proven = information_bound(
        model, base, robot.limits, np.random.default_rng(0), settings=settings
    )
    estimate = estimated_bound(design.problem, design.z, np.random.default_rng(1))
    assert estimate.kind == "estimated"
    # 0.02 of a decade over eight parameters is half a percent of efficiency.
    assert proven.attained - 0.02 < estimate.log10_det < proven.log10_det + 0.02


def test_no_design_beats_an_estimate_that_hardly_looked(design: Design) -> None:
    estimate = estimated_bound(design.problem, design.z, np.random.default_rng(2), FEW)
    assert estimate.efficiency(design.J_d, len(design.problem.instants)) <= 1.0


def test_two_joints_are_certified(design: Design) -> None:
    found = d_efficiency(design, np.random.default_rng(0), QUICK)
    assert found.kind == "certified"
    assert 0.1 < found.value < 0.6
    gap = design.J_d_continuous - found.J_d_bound
    assert found.value == pytest.approx(10 ** (gap / len(design.problem.base)))


def test_without_a_proof_it_is_an_estimate_and_says_so(design: Design) -> None:
    found = d_efficiency(design, np.random.default_rng(0), Effort(proofs=(), search=FEW))
    assert found.kind == "estimated"
    assert "not proven" in found.how


def test_with_a_prior_there_is_none(design: Design) -> None:
    prior = np.eye(len(design.problem.base))
    problem = dataclasses.replace(design.problem, prior=prior)
    with pytest.raises(NoBound, match="earlier experiments"):
        d_efficiency(dataclasses.replace(design, problem=problem), np.random.default_rng(0))


@pytest.mark.parametrize("proofs", [QUICK.proofs, ()], ids=["proof", "estimate"])
def test_at_the_deadline_there_is_none_and_that_is_why(design: Design, proofs) -> None:
    with pytest.raises(NoBound, match="the CPU time set aside for it did not suffice"):
        d_efficiency(design, np.random.default_rng(0), Effort(proofs, FEW, cpu_seconds=0.0))


def test_a_bound_that_fails_is_no_error_of_the_design(design: Design) -> None:
    impossible = np.diag([1.0, -1.0])  # no noise has it
    problem = dataclasses.replace(design.problem, covariance=impossible)
    with pytest.raises(NoBound, match="no bound was found: Matrix is not positive definite"):
        d_efficiency(dataclasses.replace(design, problem=problem), np.random.default_rng(0), QUICK)
