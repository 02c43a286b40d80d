import dataclasses
import json

import numpy as np
import plotly.graph_objects as go
import pytest

from oed.experiment.dataset import DataSet
from oed.experiment.recording import Role
from oed.report.chart import Chart
from oed.report.check_charts import range_chart, signal_charts
from oed.robot.builtin import imi_scara

RANGES: dict[Role, tuple[float, float]] = {"estimation": (-1.0, 1.5), "test": (0.25, 0.5)}


@pytest.fixture(scope="module")
def dataset() -> DataSet:
    """Two joints named awkwardly; the second moves half as far as the first."""
    t = np.arange(0, 4, 0.01)
    swing = 0.5 - 0.5 * np.cos(2 * np.pi * t)
    q = [low + (high - low) * swing[:, None] * [1.0, 0.5] for low, high in RANGES.values()]
    robot = imi_scara()
    joints = tuple(
        dataclasses.replace(joint, name=name)
        for joint, name in zip(robot.joints, ("shoulder <b>", "elbow"), strict=True)
    )
    robot = dataclasses.replace(robot, joints=joints)
    return DataSet.from_arrays(robot, t=[t, t], q=q, tau=q, roles=list(RANGES))


def test_are_figures_that_plotly_knows(dataset):
    for chart in (range_chart(dataset), *signal_charts(dataset)):
        go.Figure(json.loads(chart.json))


def test_bars_reach_from_the_lowest_to_the_highest_position(dataset):
    bars = {trace["name"]: trace for trace in range_chart(dataset).traces}
    limits = dataset.robot.limits.position
    assert bars.pop("limits")["base"].tolist() == limits[:, 0].tolist()
    for role, (low, high) in RANGES.items():
        assert bars[role]["base"].tolist() == [low, low]
        np.testing.assert_allclose(bars[role]["x"], [high - low, (high - low) / 2])
    assert bars["test"]["customdata"] == ["0.25 to 0.5 rad", "0.25 to 0.375 rad"]
    assert bars["test"]["y"] == ["shoulder &lt;b&gt;", "elbow"]


def test_limits_that_the_robot_lacks_are_left_out(dataset):
    limits = dataclasses.replace(dataset.robot.limits, position=np.full((2, 2), [-np.inf, np.inf]))
    robot = dataclasses.replace(dataset.robot, limits=limits)
    chart = range_chart(dataclasses.replace(dataset, robot=robot))
    assert [trace["name"] for trace in chart.traces] == list(RANGES)


def test_signals_are_those_of_the_log_from_its_first_row(dataset):
    q, tau = signal_charts(dataset)
    for chart, unit in ((q, "rad"), (tau, "N m")):
        assert [trace["yaxis"] for trace in chart.traces] == ["y", "y2", "y", "y2"]
        assert titles(chart) == [f"shoulder &lt;b&gt; [{unit}]", f"elbow [{unit}]"]
    first = q.traces[2]
    assert first["x"][0] == 0
    np.testing.assert_array_equal(first["y"], dataset.test[0].q[:, 0].astype(np.float32))
    assert " rad at " in first["hovertemplate"]
    assert [trace["showlegend"] for trace in q.traces] == [True, False, True, False]


def titles(chart: Chart) -> list[str]:
    return [note["text"] for note in chart.figure["layout"]["annotations"]]
