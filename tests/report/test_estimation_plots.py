from pathlib import Path

import numpy as np
import pytest

from oed.report.estimation_plots import plot_residuals, plot_torques
from oed.report.style import save_figure


def recording(joints: int, samples: int):
    rng = np.random.default_rng(joints)
    t = np.arange(samples) * 1e-3
    torque = np.sin(t[:, None] * np.arange(1, joints + 1))
    return t, torque, torque + 0.1 * rng.normal(size=torque.shape)


@pytest.mark.parametrize("joints", [1, 2, 7])
def test_draws_every_joint_under_its_name(joints: int) -> None:
    t, predicted, measured = recording(joints, 500)
    names = [f"joint_{j}" for j in range(joints)]
    figure = plot_torques(t, measured, predicted, names)
    assert [axes.get_title(loc="left") for axes in figure.axes] == names
    for j, axes in enumerate(figure.axes):
        lines = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
        np.testing.assert_array_equal(lines["measured"], measured[:, j])
        np.testing.assert_array_equal(lines["predicted"], predicted[:, j])


def test_the_band_of_a_residual_is_the_rms_given() -> None:
    t, predicted, measured = recording(2, 500)
    figure = plot_residuals(t, measured - predicted, ["a", "b"], np.array([0.1, 0.25]))
    heights = [np.asarray(line.get_ydata())[0] for line in figure.axes[1].get_lines()[1:]]
    assert heights == [0.25, -0.25]
    assert figure.axes[1].get_title(loc="right") == "rms 0.250"


def test_a_long_recording_makes_small_files(tmp_path: Path) -> None:
    t, predicted, measured = recording(7, 30_000)
    figure = plot_torques(t, measured, predicted, [f"j{j}" for j in range(7)])
    for file in save_figure(figure, tmp_path / "torques"):
        assert file.stat().st_size < 700_000


def test_a_dollar_in_a_name_is_a_dollar() -> None:
    t, predicted, measured = recording(1, 50)
    figure = plot_torques(t, measured, predicted, ["$x_{"])
    figure.draw_without_rendering()
    assert figure.axes[0].get_title(loc="left") == "$x_{"


def test_refuses_names_that_do_not_match_the_joints() -> None:
    t, predicted, measured = recording(2, 50)
    with pytest.raises(ValueError, match="3 joint names for 2 joints"):
        plot_torques(t, measured, predicted, ["a", "b", "c"])
