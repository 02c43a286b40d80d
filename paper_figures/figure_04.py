"""Figure 4: recursive estimates along the trajectories for J_k."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_recursion
from paper_figures.reading import columns, parameter_symbol, settings, unit_symbol
from paper_figures.writing import write

CAPTION = (
    "Recursive least-squares estimates over the samples of the estimation repetitions of the "
    "trajectories for J_k, with twice the deviations of (8). They settle: over the last repetition "
    "no estimate moves by more than three of its deviations at that repetition's start. Inertia "
    "and viscous friction of joint 1, of which its torque is mostly made, end within a quarter of "
    "the truth, and no friction drives."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    table = columns(results / "figures" / "recursion.csv")
    given = settings(results)
    names = given["parameters"]
    estimates, std = (
        np.stack([table[f"{kind}_{p + 1}"].astype(float) for p in range(len(names))], axis=1)
        for kind in ("xi", "std")
    )
    samples = int(given["samples"])
    moved = np.abs(estimates[-1] - estimates[-samples - 1])
    assert (moved < 3 * std[-samples - 1]).all()
    truth = np.array(given["truth"])
    inertia_1, viscous_1, friction = 0, 5, slice(4, 8)
    for p in (inertia_1, viscous_1):
        assert abs(estimates[-1, p] / truth[p] - 1) < 0.25
    assert (estimates[-1, friction] > 0).all()
    labels = [f"{parameter_symbol(name)} [{unit_symbol(unit)}]" for name, unit in names]
    return draw_recursion(table["sample"].astype(float), estimates, std, truth, labels)


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
