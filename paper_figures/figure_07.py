"""Figure 7: the test trajectory."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from paper_figures.drawing import draw_design
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
    return draw_design(results, "test")


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
