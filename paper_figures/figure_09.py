"""Figure 9: the J_d-optimal trajectories."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from paper_figures.drawing import draw_design
from paper_figures.reading import design_value
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
    assert design_value(results, "J_d, GA", "J_d") > design_value(results, "J_k, GA", "J_d")
    return draw_design(results, "J_d, GA")


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
