"""Base parameters: published counts, the same torque, and the traps."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.base_parameters import find_base_parameters
from oed.dynamics.effects import Parameter, RotorInertia
from oed.dynamics.identifiability import Route, base_parameters, rigid_body_base_parameters
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.errors import RankUndetermined
from oed.robot import Robot, arm_joints, imi_scara, load_robot
from oed.robot.builtin import IMI_BASE_PARAMETERS, IMI_LINK_LENGTHS
from tests.paths import example_robot

COUNTS = {
    "ur_description/urdf/ur3_robot.urdf": 36,
    "ur_description/urdf/ur5_robot.urdf": 36,
    "ur_description/urdf/ur10_robot.urdf": 36,
    "panda_description/urdf/panda.urdf": 43,
    "double_pendulum_description/urdf/double_pendulum.urdf": 6,
    # 38 as written: its first axis is 2.7e-6 rad off the vertical, by a rounded pi.
    "so_arm_description/urdf/so101.urdf": 36,
}


def _arm(name: str) -> Robot:
    path = example_robot(name)
    return load_robot(path, joints=arm_joints(path))


@pytest.mark.parametrize("route", ["torque", "energy"])
@pytest.mark.parametrize(("name", "count"), COUNTS.items())
def test_torque_and_energy_models_have_the_published_number(
    name: str, count: int, route: Route
) -> None:
    assert len(rigid_body_base_parameters(_arm(name), route=route)) == count


@pytest.mark.parametrize("route", ["torque", "energy"])
def test_the_scara_has_the_papers_four(route: Route) -> None:
    base = rigid_body_base_parameters(imi_scara(), route=route)
    values = dict(zip(base.expressions, base.from_standard(imi_scara().parameters), strict=True))
    expected = dict(
        zip(("Izz_1 + 0.359^2 m_2", "mx_2", "my_2", "Izz_2"), IMI_BASE_PARAMETERS, strict=True)
    )
    assert values == pytest.approx(expected)


def test_torque_and_energy_regroup_alike() -> None:
    torque, energy = (
        rigid_body_base_parameters(_arm("panda_description/urdf/panda.urdf"), route=route)
        for route in ("torque", "energy")
    )
    assert torque.names == energy.names
    assert torque.regrouping == pytest.approx(energy.regrouping, abs=1e-8)


def test_predicts_the_same_torque() -> None:
    robot = _arm("ur_description/urdf/ur5_robot.urdf")
    model = TorqueModel.standard(robot, offset=True)
    base = base_parameters(model)
    rng = np.random.default_rng(7)
    full = np.concatenate([robot.parameters, rng.normal(size=len(model.parameters) - 60)])
    columns = model.columns(random_motion(robot, 30, rng))
    assert base.reduce(columns) @ base.from_standard(full) == pytest.approx(columns @ full)
    assert columns @ base.to_standard(base.from_standard(full)) == pytest.approx(columns @ full)


def test_units_do_not_change_the_rank() -> None:
    rng = np.random.default_rng(8)
    regressor = rng.normal(size=(40, 3)) @ rng.normal(size=(3, 5))
    names = [Parameter(f"x_{i}", "", None) for i in range(5)]
    scaled = find_base_parameters(regressor * 10.0 ** np.arange(-6, 9, 3), names)
    assert len(scaled) == len(find_base_parameters(regressor, names)) == 3


def test_refuses_to_guess_the_rank() -> None:
    rng = np.random.default_rng(9)
    left, _ = np.linalg.qr(rng.normal(size=(50, 6)))
    right, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    slide = left @ np.diag(10.0 ** -np.arange(0, 12, 2)) @ right.T
    with pytest.raises(RankUndetermined) as raised:
        find_base_parameters(slide, [Parameter(f"x_{i}", "", None) for i in range(6)])
    assert len(raised.value.singular_values) == 6


@pytest.mark.parametrize("route", ["torque", "energy"])
def test_sees_through_rounded_right_angles(route: Route) -> None:
    panda = _arm("panda_description/urdf/panda.urdf")
    base = rigid_body_base_parameters(_with_rounded_angles(panda), route=route)
    assert len(base) == 43
    assert "numerical rank 45" in base.note
    as_written = (base.singular_values > 1e-8 * base.singular_values[0]).sum()
    assert as_written == 45


def test_says_nothing_where_nothing_is_rounded() -> None:
    assert rigid_body_base_parameters(imi_scara(), route="torque").note == ""


def test_the_first_rotor_is_absorbed_and_the_second_is_not() -> None:
    model = TorqueModel.standard(imi_scara()).with_effects(RotorInertia(0), RotorInertia(1))
    base = base_parameters(model)
    assert "Izz_1 + 0.359^2 m_2 + Ia_1" in base.expressions
    assert "Ia_2" in base.names
    squared = IMI_LINK_LENGTHS[0] ** 2
    row = base.regrouping[base.names.index("Izz_1")]
    assert row[[10, model_column(model, "Ia_1")]] == pytest.approx([squared, 1.0])


def model_column(model: TorqueModel, name: str) -> int:
    return [parameter.name for parameter in model.parameters].index(name)


def _with_rounded_angles(robot: Robot) -> Robot:
    """The robot with every right angle, the vertical first axis too, written to five digits."""
    tilt = 1.5708 - np.pi / 2
    c, s = np.cos(tilt), np.sin(tilt)
    about_x = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    joints = tuple(dataclasses.replace(joint, R_PJ=joint.R_PJ @ about_x) for joint in robot.joints)
    return dataclasses.replace(robot, joints=joints)


def test_a_length_of_the_arm_is_named_before_twice_a_shorter_one() -> None:
    """Of an arm with links of 0.2 m and 0.4 m: "2 0.2 m_3" would be read twice."""
    column = np.random.default_rng(0).normal(size=20)
    parameters = [Parameter("mx_2", "kg m", None), Parameter("m_3", "kg", None)]
    lengths = (0.2, 0.4)
    base = find_base_parameters(
        np.column_stack([column, 0.4 * column]), parameters, lengths=lengths
    )
    assert base.expressions == ("mx_2 + 0.4 m_3",)
    base = find_base_parameters(
        np.column_stack([column, 0.8 * column]), parameters, lengths=lengths
    )
    assert base.expressions == ("mx_2 + 2 0.4 m_3",)
