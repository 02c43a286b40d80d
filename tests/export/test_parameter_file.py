import numpy as np
import pytest
import yaml

from oed.dynamics.models import build_model
from oed.export.parameter_file import ParameterTable, write_parameters
from oed.robot import load_robot


def test_reads_back_with_units_and_intervals(tmp_path):
    robot = load_robot("builtin:imi_scara")
    model = build_model("standard", robot)
    values = np.arange(24.0) / 7
    table = ParameterTable(
        model.parameters,
        values,
        np.column_stack([values - 1, values + 1]),
        np.linspace(0, 1, 24),
        np.arange(24) == 10,
    )
    path = write_parameters(
        table,
        tmp_path / "parameters.yaml",
        robot=robot.name,
        joints=robot.joint_names,
        method="test",
    )
    read = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert set(read["parameters"]) == set(robot.joint_names)
    mass = read["parameters"]["joint_2"]["m_2"]
    assert mass["value"] == values[10]
    assert mass["unit"] == "kg"
    assert mass["at_bound"] is True
    assert read["parameters"]["joint_1"]["m_1"]["at_bound"] is False
    assert mass["interval"] == pytest.approx([values[10] - 1, values[10] + 1])
    assert sum(len(joint) for joint in read["parameters"].values()) == 24


def test_no_interval_is_no_interval(tmp_path):
    robot = load_robot("builtin:imi_scara")
    model = build_model("standard", robot)
    table = ParameterTable(model.parameters, np.ones(24), None, np.ones(24), np.zeros(24, bool))
    path = write_parameters(
        table, tmp_path / "p.yaml", robot="r", joints=robot.joint_names, method="test"
    )
    assert "interval:" not in path.read_text(encoding="utf-8")
