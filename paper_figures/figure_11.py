"""Figure 11: measured and reconstructed torque, J_d."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from paper_figures.drawing import draw_reconstruction
from paper_figures.writing import write

CAPTION = (
    "Measured and reconstructed torque over two repetitions of the J_d-optimal trajectories: they "
    "are correlated by more than 0.8 on both joints, and of the same size within 15 %."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    return draw_reconstruction(results, "J_d")


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
