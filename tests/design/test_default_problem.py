"""The problem of an arm with a file and no wishes: scaled, limited in torque where that can be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.tree import MultibodyForces

from oed.design.default_limits import with_default_limits
from oed.design.default_problem import CANNOT_STAND, ProblemSettings, default_problem
from oed.design.problem import DesignProblem
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot, imi_scara, load_robot
from oed.robot.robot_file import load_plant

GRAVITY = 9.81
MASS, ARM = 3.0, 0.4  # [kg] and [m] of the pendulum's point mass
HOLDING = MASS * GRAVITY * ARM  # [N m] that holds it level


def pendulum(folder: Path, effort: float, mass: float = MASS) -> Robot:
    """A point mass on a joint about y, level at zero, which is mid-range."""
    inertial = f'<inertial><origin xyz="{ARM} 0 0"/><mass value="{mass}"/>'
    inertial += '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>'
    text = f"""<robot name="pendulum"><link name="base"/>
<link name="arm">{inertial if mass else ""}</link>
<joint name="swing" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-1.5" upper="1.5" velocity="3" effort="{effort}"/></joint></robot>"""
    (folder / "pendulum.urdf").write_text(text)
    return with_default_limits(load_robot(folder / "pendulum.urdf"))[0]


def problem_of(robot: Robot, **wishes) -> tuple[DesignProblem, tuple[str, ...]]:
    settings = ProblemSettings(instants=40, **wishes)
    return default_problem(TorqueModel.standard(robot), settings, np.random.default_rng(0))


def drakes_torque(robot: Robot, motion: Motion) -> np.ndarray:
    plant = load_plant(robot.source)
    context = plant.CreateDefaultContext()
    torque = []
    for q, dq, ddq in zip(motion.q, motion.dq, motion.ddq, strict=True):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, dq)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        torque.append(plant.CalcInverseDynamics(context, ddq, forces))
    return np.array(torque)


def test_random_motions_excite_every_scaled_column_alike() -> None:
    problem, _ = problem_of(imi_scara())
    rng = np.random.default_rng(7)
    fresh = [problem.information(problem.random_start(rng)) for _ in range(40)]
    diagonal = np.diag(np.mean(fresh, axis=0))
    assert ((diagonal > 0.3) & (diagonal < 3.0)).all()
    bare = np.diag(problem.information(problem.random_start(rng), scaled=False))
    assert bare.max() / bare.min() > 10.0


def test_the_condition_is_that_of_scaled_columns() -> None:
    problem, _ = problem_of(imi_scara(), criterion="J_k")
    assert problem.scaling is not None
    z = problem.random_start(np.random.default_rng(3))
    motion = problem.trajectory.motion(z, problem.instants)
    rows = problem.base.reduce(problem.model.regressor(motion)).reshape(-1, len(problem.base))
    scaled = rows * problem.scaling
    truth = np.log10(np.linalg.cond(scaled.T @ scaled))
    assert problem.cost(z) == pytest.approx(truth, abs=1e-6)
    assert abs(truth - np.log10(np.linalg.cond(rows.T @ rows))) > 0.5


def test_settings_are_kept() -> None:
    problem, _ = problem_of(imi_scara(), horizon=4.0, harmonics=3, at_rest=True, criterion="E")
    assert (problem.trajectory.horizon, len(problem.instants)) == (4.0, 40)
    assert problem.criterion == "E"
    z = problem.random_start(np.random.default_rng(0))
    ends = problem.trajectory.motion(z, np.array([0.0, 4.0]))
    middle = problem.trajectory.motion(z, np.array([1.3]))
    assert np.abs(middle.dq).max() > 0.01
    np.testing.assert_allclose(ends.dq, 0.0, atol=1e-9)
    np.testing.assert_allclose(ends.ddq, 0.0, atol=1e-9)
    # Three harmonics: the seventh and all further Fourier coefficients vanish.
    t = np.arange(64) * (4.0 / 64)
    spectrum = np.abs(np.fft.rfft(problem.trajectory.motion(z, t).q, axis=0))
    np.testing.assert_allclose(spectrum[4:], 0.0, atol=1e-9)
    assert spectrum[3].min() > 1e-6


def test_random_motions_keep_the_effort_limits_by_drakes_reckoning(tmp_path: Path) -> None:
    robot = pendulum(tmp_path, effort=1.15 * HOLDING)
    problem, notes = problem_of(robot)
    assert any(note.startswith("torque is limited") for note in notes)
    rng = np.random.default_rng(0)
    t = np.linspace(0.0, problem.trajectory.horizon, 1500)
    largest = []
    for _ in range(5):
        motion = problem.trajectory.motion(problem.random_start(rng), t)
        largest.append(np.abs(drakes_torque(robot, motion)).max())
    assert max(largest) <= 1.15 * HOLDING
    free, _ = problem_of(robot, torque=False)
    rng = np.random.default_rng(0)
    loose = [free.trajectory.motion(free.random_start(rng), t) for _ in range(5)]
    assert max(np.abs(drakes_torque(robot, m)).max() for m in loose) > 1.15 * HOLDING


@pytest.mark.parametrize(("share", "is_limited"), [(0.5, False), (1.05, False), (1.2, True)])
def test_effort_that_cannot_hold_the_arm_is_not_taken_for_a_limit(
    share: float, is_limited: bool, tmp_path: Path
) -> None:
    # Gravity alone may take nine tenths of an effort limit.
    problem, notes = problem_of(pendulum(tmp_path, effort=share * HOLDING))
    assert problem.limits_torque == is_limited
    assert (CANNOT_STAND in notes) != is_limited


def test_torque_is_left_free_where_there_is_no_ground_for_a_limit(tmp_path: Path) -> None:
    for robot, wish, reason in (
        (pendulum(tmp_path, effort=100.0), {"torque": False}, "switched off"),
        (pendulum(tmp_path, effort=0.0), {}, "no effort limits"),
        (pendulum(tmp_path, effort=100.0, mass=0.0), {}, "no inertia"),
    ):
        problem, notes = problem_of(robot, **wish)
        assert not problem.limits_torque
        assert any(reason in note for note in notes)
