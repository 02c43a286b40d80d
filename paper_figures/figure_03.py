"""Figure 3: evolution of the genetic algorithm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_generations
from paper_figures.reading import columns, published
from paper_figures.writing import write

CAPTION = (
    "Best and mean fitness of each generation. The best individual is never lost, and the "
    "search ends clearly better than the best of the random first generation."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    table = columns(results / "figures" / "generations.csv")
    best, mean, paper = {}, {}, {}
    for criterion in ("J_k", "J_d"):
        mine = table["criterion"] == criterion
        generation = table["generation"][mine].astype(float)
        best[criterion], mean[criterion] = (
            table[name][mine].astype(float) for name in ("best", "mean")
        )
        paper[criterion] = published(results, criterion, f"{criterion} =")
        so_far = table["best_so_far"][mine].astype(float)
        np.testing.assert_allclose(so_far, best[criterion], rtol=1e-5)
    assert best["J_k"][-1] < best["J_k"][0]
    assert best["J_d"][-1] > best["J_d"][0]
    return draw_generations(generation, best, mean, published=paper)


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
