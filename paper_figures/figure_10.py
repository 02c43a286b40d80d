"""Figure 10: residuals, J_d, estimation set."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_residuals
from paper_figures.reading import reproduced, settings, torque
from paper_figures.writing import write

CAPTION = (
    "Torque residuals on the estimation repetitions of the J_d-optimal trajectories; their "
    "rms is the one in the table, and below half of the torque's."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    t, measured, predicted = torque(results, "J_d", "estimation")
    residual = measured - predicted
    rms = np.sqrt((residual**2).mean(axis=0))
    for j, value in enumerate(rms):
        stated = reproduced(results, "J_d", f"rms, estimation set, joint {j + 1}")
        assert abs(value - stated) < 1e-3 * stated, "the table states another rms"
        assert value < 0.5 * np.sqrt((measured[:, j] ** 2).mean())
    given = settings(results)
    breaks = [float(given["horizon"]) * k for k in range(1, int(given["repetitions"]))]
    return draw_residuals(t, residual, breaks)


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
