"""Figure 9: the J_d-optimal trajectories."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from paper_figures.drawing import draw_design
from paper_figures.reading import of_design, trajectory
from paper_figures.writing import write

CAPTION = (
    "The J_d-optimal trajectories of the genetic algorithm, the run that figure 3 shows: "
    "they keep all limits, proven (dotted where near), their information determinant is higher than that "
    "of the trajectories for J_k, and both joints move faster."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    first, second = (of_design(results, criterion) for criterion in ("J_k", "J_d"))
    assert second["margin"] <= 0
    assert second["J_d"] > first["J_d"]
    speeds = [(trajectory(results, name)[2] ** 2).mean(axis=0) for name in ("J_k", "J_d")]
    assert (speeds[1] > speeds[0]).all()
    return draw_design(results, "J_d")


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
