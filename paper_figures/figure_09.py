"""Figure 9: the J_d-optimal trajectories."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_trajectories
from paper_figures.reading import design_value, settings, trajectory
from paper_figures.writing import write

CAPTION = (
    "The J_d-optimal trajectories of the genetic algorithm: they keep all limits (dotted "
    "where near), and their information determinant is higher than that of the J_k-optimal "
    "ones."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    t, q, dq, ddq = trajectory(results, "J_d, GA")
    given = settings(results)
    limits = [np.array(given[f"{kind}_limit"]) for kind in ("position", "velocity", "acceleration")]
    for values, limit in zip((q, dq, ddq), limits, strict=True):
        assert (np.abs(values) <= limit * (1 + 1e-6)).all(), "a limit is left"
    assert design_value(results, "J_d, GA", "J_d") > design_value(results, "J_k, GA", "J_d")
    return draw_trajectories(t, q, dq, ddq, limits)


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
