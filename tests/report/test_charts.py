import base64
import json

import numpy as np
import plotly.graph_objects as go
import pytest

from oed.report.chart import LINE_POINTS, POINTS, Chart, line, points_for
from oed.report.estimation_charts import residual_chart, spectrum_chart, torque_chart
from oed.report.parameter_charts import interval_charts
from tests.report.chart_examples import JOINTS, UNITS, charts


def read(values: dict[str, str]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(values["bdata"]), dtype=f"<{values['dtype']}")


@pytest.mark.parametrize("chart", charts(3000), ids=lambda chart: chart.caption[:8])
def test_is_a_figure_that_plotly_knows(chart: Chart) -> None:
    figure = json.loads(chart.json)
    go.Figure(figure)  # refuses keys and values that it does not know
    assert "<" not in chart.json


def test_numbers_arrive_as_they_were() -> None:
    t = np.arange(500) * 0.5
    torque = np.sin(t)[:, None]
    models = {"before": 3 * torque, "after": 2 * torque}
    chart = torque_chart(t, torque, models, ["a"], ["N m"], points=1000, caption="")
    measured, before, predicted = json.loads(chart.json)["data"]
    assert [measured["name"], before["name"], predicted["name"]] == ["measured", "before", "after"]
    np.testing.assert_array_equal(read(measured["x"]), t.astype(np.float32))
    np.testing.assert_array_equal(read(measured["y"]), torque[:, 0].astype(np.float32))
    np.testing.assert_array_equal(read(predicted["y"]), 2 * torque[:, 0].astype(np.float32))


def test_a_peak_of_one_sample_survives_the_thinning() -> None:
    y = np.zeros(100_000)
    y[54_321] = 7.0
    thinned = line(np.arange(100_000.0), y, 1000)
    assert len(thinned["y"]) <= 1000
    assert thinned["x"][thinned["y"].argmax()] == 54_321


def test_points_of_a_page_are_bounded_whatever_the_arm() -> None:
    assert points_for(1) == LINE_POINTS
    assert all(lines * points_for(lines) <= POINTS for lines in (1, 63, 270))


def test_units_and_names_are_those_of_the_joints() -> None:
    t, torque = np.arange(10.0), np.ones((10, 3))
    rms, left = {"m": np.ones(3)}, {"m": torque}
    chart = residual_chart(t, left, rms, JOINTS, UNITS, band=rms["m"], points=100, caption="")
    titles = [note["text"] for note in chart.figure["layout"]["annotations"]]
    assert titles == ["shoulder &lt;b&gt;: rms 1 N m", "$elbow_{: rms 1 N m", "slide: rms 1 N"]
    assert [t["hovertemplate"].split()[1:3] for t in chart.traces][2] == ["N", "at"]
    assert [trace["yaxis"] for trace in chart.traces] == ["y", "y2", "y3"]


def test_the_band_of_a_residual_is_the_one_given() -> None:
    t, band = np.arange(10.0), np.array([0.1, 0.25])
    left = {"m": np.ones((10, 2))}
    chart = residual_chart(
        t, left, {"m": np.ones(2)}, ["a", "b"], ["N m"] * 2, band=band, points=9, caption=""
    )
    edges = [(s["yref"], s["y0"], s["y1"]) for s in chart.figure["layout"]["shapes"]]
    assert edges == [("y", -0.1, -0.1), ("y", 0.1, 0.1), ("y2", -0.25, -0.25), ("y2", 0.25, 0.25)]


def test_the_spectrum_leaves_out_zero_frequency_and_marks_the_cut_off() -> None:
    frequency = np.linspace(0, 500, 101)
    chart = spectrum_chart(
        frequency, np.ones((101, 1)), ["a"], ["N m"], cutoff=30.0, points=400, caption=""
    )
    assert chart.traces[0]["x"][0] == 5.0
    assert chart.figure["layout"]["shapes"][0]["x0"] == 30.0
    assert chart.figure["layout"]["yaxis"]["title"]["text"] == "density [(N m)²/Hz]"


def test_an_interval_that_holds_zero_is_hollow() -> None:
    values, interval = np.array([1.0, 2.0]), np.array([[-0.5, 2.5], [1.5, 2.25]])
    (chart,) = interval_charts(["a", "b"], values, interval, ["kg", "kg"], caption="")
    trace = chart.traces[0]
    assert trace["marker"]["color"][0] == "#ffffff" != trace["marker"]["color"][1]
    np.testing.assert_allclose(trace["error_x"]["array"], [1.5, 0.25])
    np.testing.assert_allclose(trace["error_x"]["arrayminus"], [1.5, 0.5])


def test_each_unit_has_a_chart_of_its_own() -> None:
    values, interval = np.ones(3), np.tile([0.5, 1.5], (3, 1))
    made = interval_charts(["a", "b", "c"], values, interval, ["kg", "N m", "kg"], caption="")
    assert [len(chart.traces[0]["x"]) for chart in made] == [2, 1]


def test_residuals_of_two_models_are_told_apart_by_name_colour_and_rms() -> None:
    t, left = np.arange(10.0), {"before": np.full((10, 1), 3.0), "after": np.ones((10, 1))}
    rms = {"before": np.array([3.0]), "after": np.array([1.0])}
    chart = residual_chart(t, left, rms, ["a"], ["N"], band=rms["after"], points=20, caption="")
    before, after = chart.traces
    assert (before["name"], after["name"]) == ("before", "after")
    assert before["line"]["color"] != after["line"]["color"]
    assert before["hovertemplate"] == "%{y:.4g} N at %{x:.3f} s"
    assert chart.figure["layout"]["annotations"][0]["text"] == "a: rms 3 → 1 N"
    np.testing.assert_array_equal(before["y"], 3.0)


def test_the_file_s_values_are_marked_where_there_are_any() -> None:
    values, interval = np.array([1.0, 2.0]), np.array([[0.5, 1.5], [1.5, 2.5]])
    file = np.array([np.nan, 2.25])
    (chart,) = interval_charts(["a", "b"], values, interval, ["kg"] * 2, caption="", file=file)
    marks, _ = chart.traces
    np.testing.assert_array_equal(marks["x"], [2.25])
    np.testing.assert_array_equal(marks["y"], [1.0])
    assert marks["text"] == ["b: 2.25 kg in the file"]
