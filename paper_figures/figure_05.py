"""Figure 5: residuals, J_k, estimation set."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from paper_figures.drawing import draw_residual
from paper_figures.writing import write

CAPTION = (
    "Torque residuals on the estimation repetitions of the trajectories for J_k (dotted lines "
    "part the repetitions); their rms is within a fifth of the mean over all experiments, and "
    "below half of the torque's."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    return draw_residual(results, "J_k", "estimation")


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
