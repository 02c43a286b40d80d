"""The interior-point optimiser: known optima, budgets, and always a proven design."""

import dataclasses
import signal
from collections.abc import Iterator

import numpy as np
import pytest

from oed.design.constraints import LimitConstraints, implied_velocity
from oed.design.design import Design
from oed.design.optimisers import hopping
from oed.design.optimisers.bfgs import DampedBfgs
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.nonlinear_program import solve_program
from oed.design.optimisers.result import Budget
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.robot import JointLimits
from tests.design.problems import HORIZON, classes, lopsided, paper_problem, scara

ROBOT, *_ = scara()
CLASSES = classes(ROBOT.limits)


def test_finds_a_known_optimum_on_the_limit() -> None:
    # Largest mean square speed of one harmonic within |q| <= 1 and |q''| <= 1 at period 2 pi:
    # amplitude 1, whatever the phase, mean square 1/2. Limits at 64 instants allow a crest midway
    # between two of them, so an amplitude of 1 / cos(pi / 64).
    limits = JointLimits.symmetric(position=(1.0,), velocity=(5.0,), acceleration=(1.0,))
    trajectory = FourierClass(2 * np.pi, limits, harmonics=1)
    t = trajectory.instants(64)

    def objective(z: np.ndarray) -> tuple[float, np.ndarray]:
        speed = trajectory.derivative(z, t, 1)
        return -(speed**2).mean(), trajectory.pull_back(z, t, (0 * speed, -2 * speed / len(t)))

    constraints = LimitConstraints(trajectory, limits, np.linspace(0, 2 * np.pi, 65))
    found = solve_program(objective, constraints, np.array([0.2, 0.1, 0.3]), iterations=100)
    assert found.is_converged
    assert objective(found.z)[0] == pytest.approx(-0.5 / np.cos(np.pi / 64) ** 2, abs=1e-4)
    assert found.z[0] == pytest.approx(0.0, abs=1e-3)


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C, and a request to terminate, raise KeyboardInterrupt, as while a study runs."""
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, signal.default_int_handler) for number in numbers]
    yield
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_within_the_solver_ends_it(number: signal.Signals) -> None:
    limits = JointLimits.symmetric(position=(1.0,), velocity=(5.0,), acceleration=(1.0,))
    trajectory = FourierClass(2 * np.pi, limits, harmonics=1)
    constraints = LimitConstraints(trajectory, limits, trajectory.instants(9))
    points = []

    def objective(z: np.ndarray) -> tuple[float, np.ndarray]:
        points.append(z)
        if len(points) == 3:
            signal.raise_signal(number)
        return -(z**4).sum(), -4 * z**3

    with pytest.raises(KeyboardInterrupt):
        solve_program(objective, constraints, np.array([0.2, 0.1, 0.3]), iterations=100)
    assert len(points) == 3
    assert signal.getsignal(number) is signal.default_int_handler


def test_bfgs_learns_a_quadratic() -> None:
    rng = np.random.default_rng(0)
    root = rng.standard_normal((4, 4))
    hessian = root @ root.T + np.eye(4)
    learned, x = DampedBfgs(4), np.zeros(4)
    for _ in range(60):
        learned.update(x, hessian @ x, lambda at: 0 * at)
        assert np.linalg.eigvalsh(learned.matrix)[0] > 0
        x = rng.standard_normal(4)
    np.testing.assert_allclose(learned.matrix, hessian, rtol=0.05, atol=0.05 * hessian.max())


@pytest.mark.parametrize("name", CLASSES)
def test_constraint_jacobian_is_the_derivative(name) -> None:
    trajectory = classes(lopsided())[name]
    constraints = LimitConstraints(trajectory, lopsided(), np.linspace(0, HORIZON, 7))
    rng = np.random.default_rng(0)
    z, step = trajectory.draw(rng), 1e-6 * rng.standard_normal(trajectory.size)
    change = constraints.values(z + step) - constraints.values(z - step)
    np.testing.assert_allclose(change / 2, constraints.jacobian(z) @ step, atol=1e-10)


def test_rows_within_their_bounds_mean_limits_kept() -> None:
    limits = lopsided()
    trajectory = classes(limits)["fourier"]
    t = np.linspace(0, HORIZON, 400)
    constraints = LimitConstraints(trajectory, limits, t)
    problem_free = trajectory.draw(np.random.default_rng(1))
    values = constraints.values(problem_free)
    is_kept = bool(((values >= constraints.lower) & (values <= constraints.upper)).all())
    beyond = [
        (trajectory.derivative(problem_free, t, k) > getattr(limits, kind)[:, 1]).any()
        or (trajectory.derivative(problem_free, t, k) < getattr(limits, kind)[:, 0]).any()
        for k, kind in enumerate(("position", "velocity", "acceleration", "jerk"))
    ]
    assert is_kept == (not any(beyond))


def test_the_papers_velocity_limit_follows_from_the_others() -> None:
    assert implied_velocity(ROBOT.limits, HORIZON).all()
    slow = ROBOT.limits.with_(velocity=np.array([[-3.0, 3.0], [-3.0, 3.0]]))
    assert not implied_velocity(slow, HORIZON).any()


@pytest.mark.parametrize(
    ("name", "criterion", "evaluations"), [("conservative", "J_k", 1000), ("fourier", "J_d", 300)]
)
def test_beats_the_paper_and_is_proven(name, criterion, evaluations) -> None:
    problem = paper_problem(CLASSES[name], criterion)
    found = optimise(problem, Budget(evaluations=evaluations), np.random.default_rng(0))
    design = Design.from_result(problem, found, optimiser="interior_point", seed=0)
    assert design.certificate.is_feasible
    assert design.status.is_proven
    assert str(design.status).startswith("proven feasible: position, ")
    if criterion == "J_k":
        assert design.J_k < 13.34  # Calafiore 2001, section 5
    else:
        assert design.J_d > 17.9
    costs = [point.cost for point in found.history]
    assert costs == sorted(costs, reverse=True)


def test_a_second_design_completes_the_first() -> None:
    trajectory = CLASSES["fourier"]
    rng = np.random.default_rng(0)
    first = paper_problem(trajectory)
    known = 10 * first.information(first.random_start(rng))
    problem = paper_problem(trajectory, prior=known)
    found = optimise(problem, Budget(evaluations=100), rng)
    design = Design.from_result(problem, found)
    alone = np.linalg.slogdet(design.information + known)[1] / np.log(10)
    assert alone == pytest.approx(-design.cost, abs=1e-9)
    assert alone > np.linalg.slogdet(known)[1] / np.log(10)


def test_even_no_budget_gives_a_proven_design() -> None:
    problem = paper_problem(CLASSES["harmonic"], "J_k")
    found = optimise(problem, Budget(evaluations=1), np.random.default_rng(0))
    assert Design.from_result(problem, found).certificate.is_feasible


def test_a_search_that_is_cut_short_is_worth_what_it_had_come_to() -> None:
    problem = paper_problem(CLASSES["collocation"])
    found = optimise(problem, Budget(evaluations=90), np.random.default_rng(0))
    on_the_way = [point for point in found.history if 1 < point.evaluations < 90]
    assert on_the_way
    assert on_the_way[0].cost < found.history[0].cost
    assert [p.evaluations for p in found.history] == sorted(p.evaluations for p in found.history)
    assert found.cost == problem.cost(found.z)
    assert problem.certificate(found.z).is_feasible


@pytest.mark.parametrize("evaluations", [1, 2, 37, 90, 250])
def test_the_budget_of_evaluations_is_kept_exactly(evaluations: int) -> None:
    problem = paper_problem(CLASSES["fourier"], "J_k")
    seen: list[int] = []

    class Counted(DesignProblem):
        def cost(self, z: np.ndarray) -> float:
            seen.append(1)
            return super().cost(z)

        def cost_and_gradient(self, z: np.ndarray, **given) -> tuple[float, np.ndarray]:
            seen.append(1)
            return super().cost_and_gradient(z, **given)

    fields = {f.name: getattr(problem, f.name) for f in dataclasses.fields(problem)}
    for optimiser in (optimise, hopping.optimise):
        seen.clear()
        found = optimiser(Counted(**fields), Budget(evaluations), np.random.default_rng(0))
        assert found.evaluations == len(seen) == evaluations
        assert found.cost == problem.cost(found.z)
