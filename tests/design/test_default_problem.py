"""The problem of an arm with a file and no wishes: limited in torque where that can be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.tree import MultibodyForces

from oed.design.default_limits import with_default_limits
from oed.design.default_problem import DefaultProblem, ProblemSettings, default_problem
from oed.design.design import Design
from oed.design.effort import EffortTooSmall
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.result import Budget
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot, imi_scara, load_robot
from oed.robot.robot_file import load_plant
from tests.paths import example_robot

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


def posed(robot: Robot, **wishes) -> DefaultProblem:
    return default_problem(TorqueModel.standard(robot), ProblemSettings(instants=40, **wishes))


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


def test_scaled_columns_are_excited_alike_by_random_motions() -> None:
    problem = posed(imi_scara(), scaled=True).problem
    rng = np.random.default_rng(7)
    starts = [problem.random_start(rng) for _ in range(40)]
    scaled, bare = (
        np.diag(np.mean([problem.information(z, scaled=s) for z in starts], axis=0))
        for s in (True, False)
    )
    assert ((scaled > 0.3) & (scaled < 3.0)).all()
    assert bare.max() / bare.min() > 3.0 * scaled.max() / scaled.min()


def test_the_condition_is_that_of_bare_columns_unless_scaling_is_asked_for() -> None:
    problem = posed(imi_scara(), criterion="J_k").problem
    z = problem.random_start(np.random.default_rng(3))
    motion = problem.trajectory.motion(z, problem.instants)
    rows = problem.base.reduce(problem.model.regressor(motion)).reshape(-1, len(problem.base))
    truth = np.log10(np.linalg.cond(rows.T @ rows))
    assert problem.cost(z) == pytest.approx(truth, abs=1e-6)
    other = posed(imi_scara(), criterion="J_k", scaled=True).problem
    assert other.scaling is not None
    scaled = rows * other.scaling
    assert other.cost(z) == pytest.approx(np.log10(np.linalg.cond(scaled.T @ scaled)), abs=1e-6)
    assert abs(other.cost(z) - truth) > 0.5


def test_the_papers_arm_reaches_a_condition_below_the_papers() -> None:
    problem = posed(imi_scara(), criterion="J_k").problem
    design = Design.from_result(
        problem, optimise(problem, Budget(evaluations=300), np.random.default_rng(0))
    )
    assert design.J_k < 13.34  # Calafiore 2001, section 5; the best motion known has 5.15
    assert design.J_k > 5.0
    assert design.cost == pytest.approx(np.log10(design.J_k), abs=1e-12)
    assert design.J_k_scaled is None


def test_settings_are_kept() -> None:
    problem = posed(imi_scara(), horizon=4.0, harmonics=3, at_rest=True, criterion="E").problem
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
    found = posed(robot)
    problem = found.problem
    assert any(note.startswith("torque is limited") for note in found.notes)
    rng = np.random.default_rng(0)
    t = np.linspace(0.0, problem.trajectory.horizon, 1500)
    largest = []
    for _ in range(5):
        motion = problem.trajectory.motion(problem.random_start(rng), t)
        largest.append(np.abs(drakes_torque(robot, motion)).max())
    assert max(largest) <= 1.15 * HOLDING
    free = posed(robot, torque=False).problem
    rng = np.random.default_rng(0)
    loose = [free.trajectory.motion(free.random_start(rng), t) for _ in range(5)]
    assert max(np.abs(drakes_torque(robot, m)).max() for m in loose) > 1.15 * HOLDING


def test_an_arm_that_cannot_be_held_at_mid_range_moves_where_it_can(tmp_path: Path) -> None:
    # Gravity needs cos(q) of what it needs at mid-range, which is level: 0.07 at an end.
    robot = pendulum(tmp_path, effort=0.5 * HOLDING)
    found = posed(robot)
    assert any("cannot hold itself" in note for note in found.notes)
    t = np.linspace(0.0, found.problem.trajectory.horizon, 1500)
    rng = np.random.default_rng(0)
    for _ in range(5):
        z = found.problem.random_start(rng)
        motion = found.problem.trajectory.motion(z, t)
        assert np.ptp(motion.q) > 0.05
        assert np.abs(drakes_torque(robot, motion)).max() <= 0.5 * HOLDING
        assert found.problem.certificate(z).is_feasible


def test_at_mid_range_nine_tenths_of_an_effort_limit_may_go_to_gravity(tmp_path: Path) -> None:
    for share, is_middle in ((1.05, False), (1.2, True)):
        stand = posed(pendulum(tmp_path, effort=share * HOLDING)).problem.stand
        assert stand is not None
        assert (stand[0] == 0.0) == is_middle


def test_an_arm_that_can_be_held_nowhere_is_refused_with_joint_and_ratio(tmp_path: Path) -> None:
    level = pendulum(tmp_path, effort=0.5 * HOLDING)
    near = level.limits.with_(position=np.array([[-0.1, 0.1]]))
    with pytest.raises(EffortTooSmall, match=r"joint swing needs 1\.99 times") as refusal:
        posed(level.with_limits(near))
    assert refusal.value.joint == "swing"
    assert refusal.value.ratio == pytest.approx(np.cos(0.1) / 0.5, rel=1e-3)
    free = posed(level.with_limits(near), torque=False)
    assert [limit.standing for limit in free.others] == ["given up"]


def test_inertia_in_other_units_is_told_by_the_torque_that_it_asks_for(tmp_path: Path) -> None:
    robot = pendulum(tmp_path, effort=1.5 * HOLDING)
    inertia = robot.parameters.copy()
    inertia[robot.parameter_names.index("Iyy_1")] += 1e6 * MASS * ARM**2
    with pytest.raises(EffortTooSmall, match=r"joint swing .* in other units") as refusal:
        posed(robot.with_parameters(inertia))
    # The default limit of acceleration is 15 rad/s^2; random motions reach most of it.
    most = 1e6 * MASS * ARM**2 * 15.0 / (1.5 * HOLDING)
    assert 0.1 * most < refusal.value.ratio <= most * 1.001


def test_inertia_that_no_arm_has_is_said_where_torque_is_limited_by_it() -> None:
    robot = with_default_limits(load_robot(example_robot("ur_description/urdf/ur5_robot.urdf")))[0]
    bodies = robot.parameters.reshape(-1, 10).copy()
    bodies[:, 4:] *= 100.0
    sound, wide = (
        [n for n in posed(r).notes if "placeholder" in n]
        for r in (robot, robot.with_parameters(bodies.ravel()))
    )
    assert sound == []
    assert len(wide) == 1
    assert "would be spread over" in wide[0]


@pytest.mark.parametrize(
    ("effort", "mass", "wishes", "standing", "reason"),
    [
        (100.0, MASS, {"torque": False}, ["given up"], "--no-torque"),
        (0.0, MASS, {}, [], "no effort limits"),
        (100.0, 0.0, {}, ["not checked"], "no inertia"),
    ],
)
def test_torque_that_is_not_limited_is_named(
    effort: float, mass: float, *, wishes: dict, standing: list, reason: str, tmp_path: Path
) -> None:
    found = posed(pendulum(tmp_path, effort=effort, mass=mass), **wishes)
    assert not found.problem.limits_torque
    assert [limit.standing for limit in found.others] == standing
    assert reason in " ".join([*found.notes, *map(str, found.others)])
