"""Basin hopping over sums of sines, its moves and its local solver."""

import numpy as np
import pytest

from oed.design.constraints import LimitConstraints
from oed.design.design import Design
from oed.design.optimisers import moves
from oed.design.optimisers.hopping import HoppingSettings, optimise
from oed.design.optimisers.result import Budget
from oed.design.optimisers.sequential_quadratic import solve_quadratic
from oed.design.optimisers.starts import structured_start
from oed.design.trajectories import FourierClass, HarmonicClass, term_moves
from oed.design.trajectories.term_moves import overtone, renew_term, split_term
from oed.robot import JointLimits
from tests.design.problems import classes, paper_problem, scara

ROBOT, *_ = scara()
CLASSES = classes(ROBOT.limits)


def of_terms(move):
    """A move of single terms, as one of a problem."""
    return lambda problem, z, rng: move(problem.trajectory, z, rng)


MOVES = {move.__name__: move for move in moves.GENERAL} | {
    move.__name__: of_terms(move) for move in (renew_term, split_term, overtone)
}


@pytest.mark.parametrize("name", MOVES)
def test_a_move_moves_one_joint_or_a_few_variables(name) -> None:
    problem = paper_problem(CLASSES["harmonic"])
    rng = np.random.default_rng(0)
    z = problem.random_start(rng)
    changed = [MOVES[name](problem, z.copy(), rng) != z for _ in range(20)]
    assert any(c.any() for c in changed)
    if name != "shift":
        joint = problem.trajectory.variables
        assert all(min(c[own].sum() for own in joint) == 0 for c in changed)


def test_a_split_at_one_frequency_is_the_same_motion(monkeypatch) -> None:
    monkeypatch.setattr(term_moves, "RELATIVE_SPLIT", 0.0)
    problem = paper_problem(CLASSES["harmonic"])
    trajectory, t = problem.trajectory, problem.instants
    assert isinstance(trajectory, HarmonicClass)
    z = problem.random_start(np.random.default_rng(0))
    z[trajectory.variables[:, 0]] = 0.0  # the first term of each joint does nothing
    for seed in range(20):
        split = split_term(trajectory, z.copy(), np.random.default_rng(seed))  # pyright: ignore[reportArgumentType]  # as there
        if (split != z)[trajectory.variables[:, trajectory.terms]].any():
            np.testing.assert_allclose(
                trajectory.derivative(split, t, 2), trajectory.derivative(z, t, 2), atol=1e-12
            )
            return
    pytest.fail("no split used an idle term")


@pytest.mark.parametrize("name", ["harmonic", "ramped", "fourier", "collocation"])
def test_a_neighbour_keeps_the_limits(name) -> None:
    problem = paper_problem(CLASSES[name])
    rng = np.random.default_rng(1)
    z = problem.random_start(rng)
    for _ in range(5):
        moved = moves.neighbour(problem, z, rng)
        assert not np.array_equal(moved, z)
        assert problem.violation(moved) <= 0.0
        z = moved


def test_slsqp_finds_a_known_optimum_on_the_limit() -> None:
    # As for IPOPT: amplitude 1 / cos(pi / 64), because the crest may lie between two instants.
    limits = JointLimits.symmetric(position=(1.0,), velocity=(5.0,), acceleration=(1.0,))
    trajectory = FourierClass(2 * np.pi, limits, harmonics=1)
    t = trajectory.instants(64)

    def objective(z: np.ndarray) -> tuple[float, np.ndarray]:
        speed = trajectory.derivative(z, t, 1)
        return -(speed**2).mean(), trajectory.pull_back(z, t, (0 * speed, -2 * speed / len(t)))

    constraints = LimitConstraints(trajectory, limits, np.linspace(0, 2 * np.pi, 65))
    start = np.array([0.2, 0.1, 0.3])
    found = solve_quadratic(objective, constraints, start, iterations=100)
    assert found.is_converged
    assert objective(found.z)[0] == pytest.approx(-0.5 / np.cos(np.pi / 64) ** 2, abs=1e-4)
    out_of_time = solve_quadratic(
        objective, constraints, start, iterations=10**6, cpu_seconds=0.0, tolerance=0.0
    )
    assert out_of_time.evaluations <= 10
    assert not out_of_time.is_converged


def test_the_structured_start_swings_faster_than_one_sine_could() -> None:
    problem = paper_problem(CLASSES["harmonic"])
    starts = [structured_start(problem, np.random.default_rng(seed)) for seed in range(20)]
    fastest = max(problem.trajectory.describe(z)["frequency"][:, 0].max() for z in starts)
    assert fastest > np.sqrt(5.0 / 1.5)  # (12d)
    # The third harmonic makes room for that speed: next to nothing has to be scaled away.
    swings = [np.ptp(problem.trajectory.derivative(z, problem.instants, 0), axis=0) for z in starts]
    assert np.min(swings) > 0.9 * 3.0


def test_beats_the_paper_and_is_proven() -> None:
    problem = paper_problem(CLASSES["harmonic"], "J_d")
    settings = HoppingSettings(starts=3)
    found = optimise(problem, Budget(evaluations=400), np.random.default_rng(1), settings)
    design = Design.from_result(problem, found, optimiser="hopping", seed=1)
    assert design.certificate.is_feasible
    assert design.J_d > 19.0  # Calafiore 2001, section 5: 17.9; random motions about 15
    costs = [point.cost for point in found.history]
    assert costs == sorted(costs, reverse=True)


def test_hopping_keeps_to_its_budget() -> None:
    problem = paper_problem(CLASSES["fourier"], "J_k")
    found = optimise(problem, Budget(evaluations=1), np.random.default_rng(0))
    assert Design.from_result(problem, found).certificate.is_feasible
    # One that the budget ends among its starts has not hopped, and says so.
    assert found.status == "1 chain, 1 local solution, 0 hops"
    by_time = optimise(problem, Budget(cpu_seconds=0.3), np.random.default_rng(0))
    assert 0.3 <= by_time.cpu_s < 1.5
