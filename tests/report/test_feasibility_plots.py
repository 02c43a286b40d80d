import numpy as np

from oed.report.feasibility_plots import (
    plot_link_margins,
    plot_residual_comparison,
    plot_weight_curve,
)


def test_the_curve_shows_what_was_chosen_and_what_it_is_measured_against():
    weights = np.logspace(-4, 0, 5)
    held_out = np.outer([1.2, 1.1, 1.0, 1.3, 9.0], [1.0, 1.1])
    figure = plot_weight_curve(
        weights, held_out, 0.9 * held_out, best=2, chosen=3, least_squares=1.4
    )
    panel = figure.axes[0]
    vertical = [line for line in panel.lines if line.get_label() == "chosen"]
    assert np.array_equal(vertical[0].get_xdata(), [weights[3]] * 2)
    # The end of the curve that is far off does not hide the rest.
    assert panel.get_ylim()[1] < 2.0


def test_margins_are_drawn_above_what_was_demanded():
    figure = plot_link_margins(["upper_arm", "fore_arm"], np.array([0.5, 1e-3]), 1e-4)
    panel = figure.axes[0]
    assert [label.get_text() for label in panel.get_yticklabels()] == ["upper_arm", "fore_arm"]
    assert panel.get_xlim()[0] < 1e-4


def test_both_residuals_of_each_case_are_drawn():
    figure = plot_residual_comparison(
        ["a", "b", "c"], np.array([1.0, 2, 3]), np.array([1.1, 1.9, 2.5]), ylabel="rms [N m]"
    )
    assert len(figure.axes[0].patches) == 6
