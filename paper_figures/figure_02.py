"""Figure 2: the trajectories for J_k."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from paper_figures.drawing import draw_design
from paper_figures.reading import of_design
from paper_figures.writing import write

CAPTION = (
    "The trajectories that the genetic algorithm found for J_k, the run that figure 3 shows: they "
    "keep all limits, proven (dotted where near), and their condition number is lower than "
    "that of those for J_d."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    design = of_design(results, "J_k")
    assert design["margin"] <= 0
    assert design["J_k"] < of_design(results, "J_d")["J_k"]
    return draw_design(results, "J_k")


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
