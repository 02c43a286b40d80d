"""Figure 7: the test trajectory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_trajectories
from paper_figures.reading import settings, trajectory
from paper_figures.writing import write

CAPTION = (
    "The test trajectory, which no estimate has seen: a random member of the paper's class "
    "that keeps all limits (dotted where near)."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    t, q, dq, ddq = trajectory(results, "test")
    given = settings(results)
    limits = [np.array(given[f"{kind}_limit"]) for kind in ("position", "velocity", "acceleration")]
    for values, limit in zip((q, dq, ddq), limits, strict=True):
        assert (np.abs(values) <= limit * (1 + 1e-6)).all(), "a limit is left"
    assert np.ptp(q, axis=0).min() > 0, "a joint does not move"
    return draw_trajectories(t, q, dq, ddq, limits)


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
