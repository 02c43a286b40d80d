import numpy as np
import pytest

from oed.report.comparison_plots import HitPanel, plot_target_hits


def panel(title: str, names: tuple[str, ...]) -> HitPanel:
    amounts = np.geomspace(1.0, 100.0, 30)
    curves = {name: np.linspace(0.0, 0.1 * (k + 1), 30) for k, name in enumerate(names)}
    return HitPanel(title, amounts, curves, 50.0, "evaluations")


def test_draws_every_curve_it_is_given() -> None:
    panels = [panel("one", ("a", "b")), panel("two", ("b",)), panel("three", ("a", "c"))]
    figure = plot_target_hits(panels)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["one", "two", "three"]
    drawn = figure.axes[0].get_lines()[1].get_ydata()
    np.testing.assert_array_equal(drawn, panels[0].curves["b"])
    # A name keeps its colour where another is missing.
    first, second = (figure.axes[k].get_lines() for k in (0, 1))
    assert first[1].get_color() == second[0].get_color()


def test_marks_the_budget() -> None:
    figure = plot_target_hits([panel("one", ("a",))])
    assert np.array_equal(figure.axes[0].get_lines()[-1].get_xdata(), [50.0, 50.0])


def test_refuses_an_empty_figure() -> None:
    with pytest.raises(ValueError, match="no panel"):
        plot_target_hits([])
