"""Picture of the study of rivals: predicted against observed rates of a wrong choice."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from oed.report.style import BLUE, GREY, PAGE, STYLE, new_figure

MARGIN = 0.05  # of a rate that is promised


@mpl.rc_context(STYLE)
def plot_calibration(
    panels: Sequence[tuple[str, Sequence[tuple[float, float, float, float]]]],
) -> Figure:
    """Observed over predicted rate, a panel each way to predict.

    Args:
        panels: Title, and for each case the predicted rate, the observed one, and the ends of
            the latter's interval; all from 0 to 1.
    """
    figure = new_figure(PAGE, 3.3)
    for index, (title, points) in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), index + 1)
        line = np.array([0.0, 1.0])
        axes.fill_between(line, line - MARGIN, line + MARGIN, color=GREY, alpha=0.3, linewidth=0)
        axes.plot(line, line, color=GREY)
        predicted, observed, lower, upper = np.array(points).T
        axes.errorbar(
            predicted,
            observed,
            yerr=[observed - lower, upper - observed],
            fmt="o",
            color=BLUE,
            markersize=3.5,
            elinewidth=0.6,
        )
        axes.set(
            title=title,
            xlabel="predicted rate",
            ylabel="observed rate" if index == 0 else "",
            xlim=(-0.03, 1.03),
            ylim=(-0.03, 1.03),
            aspect="equal",
        )
    return figure
