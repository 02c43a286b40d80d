"""The problem: gradients, fast path against the torque model, averages over time."""

import pickle

import numpy as np
import pytest

from oed.design.criteria import information
from oed.dynamics.compiled import compile_regressor
from oed.dynamics.motion import random_motion
from tests.design.problems import classes, paper_problem, scara

ROBOT, MODEL, BASE = scara()
CLASSES = classes(ROBOT.limits)


@pytest.mark.parametrize("native", [True, False])
def test_the_fast_regressor_is_the_torque_models(native) -> None:
    motion = random_motion(ROBOT, 101, np.random.default_rng(0))
    motion.dq[3] = 0.0  # where the sign is zero
    fast = compile_regressor(MODEL, BASE, native=native)
    exact = BASE.reduce(MODEL.columns(motion))
    np.testing.assert_allclose(fast.dense(fast.entries(motion)), exact, atol=1e-13)


def test_machine_code_and_virtual_machine_agree() -> None:
    motion = random_motion(ROBOT, 37, np.random.default_rng(1))
    compiled, interpreted = (compile_regressor(MODEL, BASE, native=n) for n in (True, False))
    if not compiled.is_native:
        pytest.skip("no C compiler on this machine")
    seeds = np.random.default_rng(2).standard_normal((len(compiled.entry_joint), 37))
    pairs = zip(
        compiled.pull_back(motion, seeds, 0.1),
        interpreted.pull_back(motion, seeds, 0.1),
        strict=True,
    )
    for a, b in pairs:
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)


def test_works_without_a_compiler(monkeypatch) -> None:
    monkeypatch.setattr("oed.dynamics.native._compiler", lambda: None)
    problem = paper_problem(CLASSES["fourier"])
    assert not problem.regressor.is_native
    assert np.isfinite(problem.cost(problem.random_start(np.random.default_rng(0))))


@pytest.mark.parametrize("name", CLASSES)
@pytest.mark.parametrize("criterion", ["J_k", "J_d", "A", "E"])
def test_gradients_are_derivatives(name, criterion) -> None:
    problem = paper_problem(CLASSES[name], criterion, prior=0.1 * np.eye(8))
    rng = np.random.default_rng(4)
    z, step = problem.random_start(rng), 1e-6 * rng.standard_normal(problem.size)
    settings = {"sign_width": 0.2, "exponent": 6.0}
    above, below = (problem.cost_and_gradient(z + s * step, **settings)[0] for s in (1, -1))
    slope = problem.cost_and_gradient(z, **settings)[1] @ step
    assert (above - below) / 2 == pytest.approx(slope, rel=1e-4, abs=1e-10)


@pytest.mark.parametrize(
    "covariance", [None, np.array([2.0, 0.5]), np.array([[2.0, 0.7], [0.7, 1]])]
)
def test_information_is_that_of_the_stacked_rows(covariance) -> None:
    problem = paper_problem(CLASSES["harmonic"], covariance=covariance)
    z = problem.random_start(np.random.default_rng(0))
    columns = BASE.reduce(MODEL.columns(problem.trajectory.motion(z, problem.instants)))
    np.testing.assert_allclose(problem.information(z), information(columns, covariance), rtol=1e-10)


def test_gradient_with_correlated_noise_scaling_and_torque_limits() -> None:
    limits = ROBOT.limits.with_(torque=np.array([[-3.0, 2.0], [-0.4, 0.5]]))
    trajectory = CLASSES["fourier"]
    problem = paper_problem(
        trajectory,
        "J_k",
        covariance=np.array([[2.0, 0.7], [0.7, 1.0]]),
        scaling=np.linspace(0.5, 2.0, 8),
        nominal=np.concatenate([ROBOT.parameters, np.zeros(4)]),
    )
    problem = type(problem)(**{**fields_of(problem), "limits": limits})
    rng = np.random.default_rng(4)
    z = paper_problem(trajectory).random_start(rng)
    assert problem.cost_and_gradient(z)[0] > problem.cost(z) + 0.1  # torque costs something here
    step = 1e-6 * rng.standard_normal(problem.size)
    above, below = (problem.cost_and_gradient(z + s * step, exponent=6.0)[0] for s in (1, -1))
    slope = problem.cost_and_gradient(z, exponent=6.0)[1] @ step
    assert (above - below) / 2 == pytest.approx(slope, rel=1e-4)
    assert problem.certificate(problem.repair(z)).is_feasible


def fields_of(problem) -> dict:
    return {name: getattr(problem, name) for name in problem.__dataclass_fields__}


def test_the_average_over_time_converges() -> None:
    problem = paper_problem(CLASSES["fourier"])
    z = problem.random_start(np.random.default_rng(2))
    coarse, fine = (problem.continuous_information(z, points=n) for n in (4000, 40_000))
    np.testing.assert_allclose(coarse, fine, rtol=0, atol=2e-3 * np.abs(fine).max())


def test_goes_to_another_process_and_back() -> None:
    problem = paper_problem(CLASSES["fourier"])
    z = problem.random_start(np.random.default_rng(0))
    value = problem.cost(z)
    assert pickle.loads(pickle.dumps(problem)).cost(z) == value  # noqa: S301  # our own bytes
