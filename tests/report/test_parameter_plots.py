import numpy as np
import pytest

from oed.report.parameter_plots import (
    plot_parameter_convergence,
    plot_parameter_intervals,
    shortened,
)


def history(parameters: int):
    samples = np.arange(10, 4000, 10)
    estimates = np.ones(parameters) + 100.0 / samples[:, None] ** 2
    half = 1 / np.sqrt(samples)[:, None, None]
    return samples, estimates, estimates[:, :, None] + half * np.array([-1.0, 1.0])


@pytest.mark.parametrize("parameters", [1, 8, 60])
def test_one_panel_a_parameter(parameters: int) -> None:
    samples, estimates, intervals = history(parameters)
    names = [f"m_{k}" for k in range(parameters)]
    figure = plot_parameter_convergence(samples, estimates, intervals, names, ["kg"] * parameters)
    assert [a.get_title(loc="left") for a in figure.axes] == [f"{name} [kg]" for name in names]


def test_early_estimates_do_not_flatten_the_rest() -> None:
    samples, estimates, intervals = history(1)
    estimates[0], intervals[0] = 1e9, [[-1e12, 1e12]]
    figure = plot_parameter_convergence(samples, estimates, intervals, ["m"], ["kg"])
    low, high = figure.axes[0].get_ylim()
    assert 0.8 < low < 1.0 < high < 1.2


def test_intervals_are_grouped_by_unit_and_keep_their_values() -> None:
    values = np.array([1.0, 5.0, -2.0])
    figure = plot_parameter_intervals(
        ["Izz", "Fc", "Ixx"], values, values - 0.5, values + 3.0, ["kg m²", "N m", "kg m²"]
    )
    panels = {axes.get_xlabel(): axes for axes in figure.axes}
    assert set(panels) == {"[kg m²]", "[N m]"}
    labels = [label.get_text() for label in panels["[kg m²]"].get_yticklabels()]
    assert labels == ["Izz", "Ixx"]
    spans = [
        np.asarray(path.vertices)[:, 0].tolist()
        for path in panels["[kg m²]"].collections[0].get_paths()
    ]
    assert spans == [[0.5, 4.0], [-2.5, 1.0]]


def test_what_is_not_told_from_zero_is_marked() -> None:
    figure = plot_parameter_intervals(
        ["a", "b"], np.array([1.0, 0.1]), np.array([0.9, -0.1]), np.array([1.1, 0.3]), ["kg", "kg"]
    )
    _, sure, unsure = figure.axes[0].collections
    assert np.asarray(sure.get_offsets())[:, 0].tolist() == [1.0]
    assert np.asarray(unsure.get_offsets())[:, 0].tolist() == [0.1]


def test_a_long_name_gives_up_its_unit_and_then_its_end() -> None:
    assert shortened("m [kg]", "m", 6) == "m [kg]"
    assert shortened("m_12 [kg]", "m_12", 6) == "m_12"
    assert shortened("abcdefgh [kg]", "abcdefgh", 6) == "abcde…"


def test_refuses_labels_that_do_not_match() -> None:
    samples, estimates, intervals = history(2)
    with pytest.raises(ValueError, match="1 names, 2 units, 2 parameters"):
        plot_parameter_convergence(samples, estimates, intervals, ["a"], ["kg", "kg"])
