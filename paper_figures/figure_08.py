"""Figure 8: residuals, J_k, test set."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from paper_figures.drawing import draw_residual
from paper_figures.writing import write

CAPTION = (
    "Torque residuals on the test trajectory with the parameters found on those for J_k; "
    "their rms is within a fifth of the mean over all experiments, and below half of the "
    "torque's."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    return draw_residual(results, "J_k", "test")


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
