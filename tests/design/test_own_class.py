"""A class of motions of a user's own goes wherever ours go."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from oed.commands.main import run
from oed.design.bound.efficiency import QUICK, d_efficiency
from oed.design.design import Design
from oed.design.optimisers import hopping, interior_point, slsqp
from oed.design.optimisers.moves import neighbour
from oed.design.optimisers.result import Budget, OptimiserResult
from oed.design.optimisers.starts import structured_start
from oed.design.prior_experiments import prior_information
from oed.design.trajectories import FourierClass, TrajectoryClass
from oed.design.trajectories.registry import Wishes, readable, trajectory_class
from oed.robot import JointLimits
from tests.design.problems import HORIZON, paper_problem, scara

ROBOT, MODEL, BASE = scara()
TURNED = 0.123  # [rad] the phase to which the class's own move turns
COMMAND = ["design", "--robot", "builtin:imi_scara", "--smoke", "--no-clearance"]


@readable
@dataclass(frozen=True)
class Wobble(TrajectoryClass):
    """q_j(t) = offset_j + a_j sin((j + 1) w t + phase_j), w = 2 pi / horizon."""

    horizon: float
    limits: JointLimits
    name = "wobble"
    is_linear = False
    has_offset = True
    is_periodic = True

    @property
    def joints(self) -> int:
        return len(self.limits.position)

    @property
    def bounds(self) -> np.ndarray:
        lower, upper = self.limits.position.T
        middle, full = np.zeros_like(lower), upper - lower
        low, high = (lower, middle, middle - 2 * np.pi), (upper, full, middle + 2 * np.pi)
        return np.stack([np.concatenate(low), np.concatenate(high)], axis=1)

    @property
    def variables(self) -> np.ndarray:
        return np.arange(3 * self.joints).reshape(3, self.joints).T

    def derivative(self, z: np.ndarray, t: np.ndarray, order: int) -> np.ndarray:
        offset, a, _ = np.reshape(z, (3, -1))
        return self._wave(z, t, order) * a + (offset if order == 0 else 0.0)

    def sensitivity(self, z: np.ndarray, t: np.ndarray, order: int) -> np.ndarray:
        a = np.reshape(z, (3, -1))[1]
        wave = self._wave(z, t, order)
        constant = np.full_like(wave, 1.0 if order == 0 else 0.0)
        return np.stack([constant, wave, a * self._wave(z, t, order, np.pi / 2)], axis=2)

    def derivative_bound(self, z: np.ndarray, order: int) -> np.ndarray:
        return np.abs(np.reshape(z, (3, -1))[1]) * self._rates**order

    def centre(self, z: np.ndarray) -> np.ndarray:
        return np.array(z[: self.joints], dtype=float)

    def shrink(self, z: np.ndarray, factors: np.ndarray) -> np.ndarray:
        offset, a, phase = np.reshape(z, (3, -1))
        return np.concatenate([offset, a * factors, phase])

    def shift(self, z: np.ndarray, distance: np.ndarray) -> np.ndarray:
        return np.concatenate([z[: self.joints] + distance, z[self.joints :]])

    def describe(self, z: np.ndarray) -> dict[str, np.ndarray]:
        return {"wobble": np.reshape(z, (3, -1))}

    @classmethod
    def restore(cls, horizon, limits, coefficients) -> tuple[Wobble, np.ndarray]:
        return cls(horizon, limits), coefficients["wobble"].reshape(-1)

    def swing(
        self, middle: np.ndarray, amplitude: np.ndarray, rate: np.ndarray
    ) -> np.ndarray:  # rates are fixed
        return np.concatenate([middle, amplitude, 0 * amplitude])

    @property
    def moves(self) -> tuple:
        def turn(z: np.ndarray, rng: np.random.Generator) -> np.ndarray:
            z[-1] = TURNED
            return z

        return (turn,)

    def slower(self, scale: float) -> Wobble:
        return Wobble(self.horizon / scale, self.limits)

    @property
    def _rates(self) -> np.ndarray:
        return 2 * np.pi / self.horizon * np.arange(1, self.joints + 1)

    def _wave(self, z: np.ndarray, t: np.ndarray, order: int, turn: float = 0.0) -> np.ndarray:
        phase = np.reshape(z, (3, -1))[2]
        angle = t[:, None] * self._rates + phase + order * np.pi / 2 + turn
        return self._rates**order * np.sin(angle)


class Open(Wobble):
    """The same motions, of which it is not known that they return."""

    is_periodic = False


@trajectory_class("wobble")
def make_wobble(wishes: Wishes) -> Wobble:
    return Wobble(wishes.horizon, wishes.limits)


WOBBLE = Wobble(HORIZON, ROBOT.limits)


def test_the_structured_start_is_the_swing_of_the_class() -> None:
    z = structured_start(paper_problem(WOBBLE), np.random.default_rng(0))
    largest = np.abs(WOBBLE.derivative(z, np.linspace(0, HORIZON, 500), 0)).max(axis=0)
    np.testing.assert_allclose(largest, 1.5, rtol=0.01)  # all of the range of positions


def test_neighbours_come_by_the_moves_of_the_class() -> None:
    problem, rng = paper_problem(WOBBLE), np.random.default_rng(0)
    z = problem.random_start(rng)
    assert any(neighbour(problem, z, rng)[-1] == TURNED for _ in range(10))


@cache
def best_of_a_grid() -> float:
    """Least cost over the phases of full swings, which is where the optimum is."""
    problem = paper_problem(WOBBLE)
    phases = np.linspace(0.0, 2 * np.pi, 25)[:-1]
    grid = [(1.5, 1.5, p, q) for p in phases for q in phases]
    return min(problem.cost(np.array([0.0, 0.0, *point])) for point in grid)


@pytest.mark.parametrize("optimiser", [interior_point, hopping, slsqp])
def test_optimisers_find_the_best_of_a_grid_within_proven_limits(optimiser) -> None:
    problem = paper_problem(WOBBLE)
    found = optimiser.optimise(problem, Budget(evaluations=400), np.random.default_rng(0))
    design = Design.from_result(problem, found)
    assert design.certificate.is_feasible
    assert design.cost < best_of_a_grid() + 0.05


def test_the_bound_allows_no_way_back_for_motions_that_return() -> None:
    problem = paper_problem(WOBBLE)
    result = OptimiserResult(problem.random_start(np.random.default_rng(0)), 0.0, (), 0, 0.0, "")
    design = Design.from_result(problem, result)
    returning = d_efficiency(design, np.random.default_rng(0), QUICK)
    open_end = dataclasses.replace(problem, trajectory=Open(HORIZON, ROBOT.limits))
    going = d_efficiency(
        dataclasses.replace(design, problem=open_end), np.random.default_rng(0), QUICK
    )
    assert going.J_d_bound > returning.J_d_bound + 0.5


def test_the_command_designs_it_and_takes_it_as_prior(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    assert (
        run(
            [
                *COMMAND,
                "--trajectory",
                "wobble",
                "--periodic",
                "--scale",
                "0.5",
                "--out",
                str(first),
            ]
        )
        == 0
    )
    record = json.loads((first / "design.json").read_text())
    assert record["class"] == "wobble"
    assert record["horizon"] == 2 * 10.0
    prior = prior_information(
        [first / "design.json"], paper_problem(FourierClass(7.0, ROBOT.limits))
    )
    restored, z = Wobble.restore(
        20.0, ROBOT.limits, {"wobble": np.array(record["coefficients"]["wobble"])}
    )
    motion = restored.motion(z, np.arange(record["instants"]) * 20.0 / record["instants"])
    H = BASE.reduce(MODEL.regressor(motion)).reshape(-1, len(BASE))
    np.testing.assert_allclose(prior, H.T @ H, rtol=1e-9, atol=1e-9 * prior.max())
    given = ["--prior", str(first / "design.json"), "--out", str(second)]
    assert run([*COMMAND, *given]) == 0
    assert json.loads((second / "design.json").read_text())["with_prior"]["J_d_log10"] > 0


def test_a_class_that_cannot_do_something_is_refused_in_a_line(tmp_path: Path, capsys) -> None:
    out = ["--out", str(tmp_path / "out")]
    assert run([*COMMAND, "--trajectory", "harmonic", "--scale", "0.5", *out]) == 2
    assert "motions of class 'harmonic' cannot be slowed down" in capsys.readouterr().err
