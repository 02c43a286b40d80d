"""What an estimate explains and what it leaves, joint by joint (Calafiore 2001, figures 5, 6, 8).

Every function draws the arrays that it is given, computes nothing, and returns the figure.
"""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
from jaxtyping import Float
from matplotlib.figure import Figure
from numpy import ndarray

from oed.report.joint_grid import joint_grid
from oed.report.panels import legend_above
from oed.report.signal_lines import draw_signal
from oed.report.style import BLUE, GREY, STYLE, VERMILION

_TORQUE = "torque [N m]"
_RESIDUAL = "residual torque [N m]"
_TIME = "time [s]"


@mpl.rc_context(STYLE)
def plot_torques(
    t: Float[ndarray, " samples"],
    measured: Float[ndarray, "samples joints"],
    predicted: Float[ndarray, "samples joints"],
    joint_names: Sequence[str],
    *,
    ylabel: str = _TORQUE,
) -> Figure:
    """Measured torque and the torque that the model reconstructs (figure 6).

    Args:
        t: (N,) time [s].
        measured: (N, n) [N m].
        predicted: (N, n) [N m].
        joint_names: (n,) names, in the order of the columns.
        ylabel: Another label where the joints are prismatic.

    Raises:
        ValueError: If there is not one name a joint.
    """
    _require_names(joint_names, measured.shape[1])
    figure, panels = joint_grid(joint_names, xlabel=_TIME, ylabel=ylabel)
    for j, panel in enumerate(panels):
        draw_signal(panel, t, measured[:, j], color=GREY, label="measured", linewidth=1.6)
        draw_signal(panel, t, predicted[:, j], color=BLUE, label="predicted", linewidth=0.7)
        panel.margins(x=0)
    legend_above(figure, panels[0])
    return figure


@mpl.rc_context(STYLE)
def plot_residuals(
    t: Float[ndarray, " samples"],
    residual: Float[ndarray, "samples joints"],
    joint_names: Sequence[str],
    rms: Float[ndarray, " joints"],
    *,
    ylabel: str = _RESIDUAL,
) -> Figure:
    """What the model leaves unexplained, with the band of one rms (figures 5 and 8).

    Args:
        t: (N,) time [s].
        residual: (N, n) measured minus predicted [N m].
        joint_names: (n,) names, in the order of the columns.
        rms: (n,) root mean square of the residual [N m].
        ylabel: Another label where the joints are prismatic.

    Raises:
        ValueError: If there is not one name a joint.
    """
    _require_names(joint_names, residual.shape[1])
    figure, panels = joint_grid(joint_names, xlabel=_TIME, ylabel=ylabel)
    for j, panel in enumerate(panels):
        draw_signal(panel, t, residual[:, j], color=BLUE, label="residual", linewidth=0.4)
        for sign, label in ((1, "± rms"), (-1, "_")):
            panel.axhline(sign * rms[j], color=VERMILION, linewidth=1.2, label=label)
        panel.set_title(
            f"rms {rms[j]:#.3g}".rstrip("."), loc="right", color=VERMILION, fontsize=7.0
        )
        panel.margins(x=0)
    legend_above(figure, panels[0])
    return figure


def _require_names(joint_names: Sequence[str], joints: int) -> None:
    if len(joint_names) != joints:
        raise ValueError(f"{len(joint_names)} joint names for {joints} joints")
