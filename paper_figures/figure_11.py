"""Figure 11: measured and reconstructed torque, J_d."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_torque
from paper_figures.reading import settings, torque
from paper_figures.writing import write

CAPTION = (
    "Measured and reconstructed torque over the first repetition of the J_d-optimal "
    "trajectories: they are correlated by more than 0.8 on both joints."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    t, measured, predicted = torque(results, "J_d", "estimation")
    one = slice(0, int(settings(results)["samples"]))
    t, measured, predicted = t[one], measured[one], predicted[one]
    for j in range(measured.shape[1]):
        assert np.corrcoef(measured[:, j], predicted[:, j])[0, 1] > 0.8
    return draw_torque(t, measured, predicted)


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
