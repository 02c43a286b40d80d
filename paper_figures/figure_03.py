"""Figure 3: evolution of the genetic algorithm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_generations
from paper_figures.reading import columns, of_design, settings
from paper_figures.writing import write

CAPTION = (
    "Best and mean fitness of each generation. From the middle of all seeds towards the best, "
    "these runs are the first that have converged: no change of a single bit improves their end. "
    "The best individual is never lost. The J_d run ends at the best of all seeds, the J_k run not."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    table = columns(results / "figures" / "generations.csv")
    best, mean = {}, {}
    for criterion in ("J_k", "J_d"):
        mine = table["criterion"] == criterion
        generation = table["generation"][mine].astype(float)
        best[criterion], mean[criterion] = (
            table[name][mine].astype(float) for name in ("best", "mean")
        )
        design = of_design(results, criterion)
        np.testing.assert_allclose(best[criterion][-1], design[criterion], rtol=1e-4)
        # In J_k less is better, in J_d more.
        sign = 1 if criterion == "J_k" else -1
        assert (sign * np.diff(best[criterion]) <= 0).all(), "the best is lost"
        assert sign * best[criterion][-1] < sign * best[criterion][0]
        assert sign * design["best of a bit's change"] >= sign * design[criterion], "not converged"
    d_optimal = of_design(results, "J_d")
    assert d_optimal["J_d"] == d_optimal["best of all seeds"], "not the best"
    return draw_generations(generation, best, mean, published=settings(results)["paper"])


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
