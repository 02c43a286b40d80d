"""How optimisers compare: target hits against what they cost, and what they depend on.

Every function draws the arrays that it is given, computes nothing, and returns the figure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import matplotlib as mpl
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from oed.report.panels import page_panels
from oed.report.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    STYLE,
    VERMILION,
)

_COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, BLACK)
_DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), "-")


@dataclass(frozen=True)
class HitPanel:
    """One panel of hit curves.

    Attributes:
        title: Problem, class and criterion.
        amounts: (P,) evaluations or seconds.
        curves: Fraction (P,) of pairs of run and target that had been hit, by optimiser.
        budget: Where runs are read; drawn as a line.
        xlabel: What `amounts` are.
    """

    title: str
    amounts: Float[ndarray, " points"]
    curves: Mapping[str, Float[ndarray, " points"]]
    budget: float
    xlabel: str


@mpl.rc_context(STYLE)
def plot_target_hits(panels: Sequence[HitPanel], *, columns: int = 2) -> Figure:
    """Fraction of targets that have been hit, against what was spent.

    Args:
        panels: Row by row; those of one row share a problem.
        columns: Panels a row.

    Raises:
        ValueError: If there is no panel.
    """
    figure, grid = page_panels(len(panels), columns=columns, row=1.45, sharey=True)
    names = list(dict.fromkeys(name for panel in panels for name in panel.curves))
    for axes, panel in zip(grid, panels, strict=True):
        _draw_hits(axes, panel, names)
    lines, labels = grid[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside upper center", ncols=len(labels))
    figure.supylabel("fraction of targets hit, over all runs", fontsize=8.0)
    return figure


def _draw_hits(axes: Axes, panel: HitPanel, names: Sequence[str]) -> None:
    for index, name in enumerate(names):
        if name in panel.curves:
            axes.step(
                panel.amounts,
                panel.curves[name],
                where="post",
                color=_COLOURS[index % len(_COLOURS)],
                linestyle=_DASHES[index % len(_DASHES)],
                label=name,
            )
    axes.axvline(panel.budget, color="#9A9A9A", linewidth=0.7)
    axes.set_xscale("log")
    axes.set_xlim(panel.amounts[0], panel.amounts[-1])
    axes.set_ylim(-0.03, 1.03)
    axes.set_title(panel.title, parse_math=False)
    axes.set_xlabel(panel.xlabel)


@dataclass(frozen=True)
class DependencePanel:
    """One panel of how a criterion depends on a bound.

    Attributes:
        xlabel: What the bound is.
        ylabel: The criterion.
        bounds: (R,) of each run.
        values: (R,) of each run.
        best_bounds: (B,) increasing.
        best_values: (B,) the best value at each.
    """

    xlabel: str
    ylabel: str
    bounds: Float[ndarray, " runs"]
    values: Float[ndarray, " runs"]
    best_bounds: Float[ndarray, " points"]
    best_values: Float[ndarray, " points"]


@mpl.rc_context(STYLE)
def plot_dependence(panels: Sequence[DependencePanel], *, columns: int = 2) -> Figure:
    """Runs as points and the best of each bound as a line.

    Args:
        panels: Row by row; those of one row share a criterion.
        columns: Panels a row.

    Raises:
        ValueError: If there is no panel.
    """
    figure, grid = page_panels(len(panels), columns=columns, row=1.9, sharey="row")
    for axes, panel in zip(grid, panels, strict=True):
        axes.plot(panel.best_bounds, panel.best_values, color=BLUE, label="best")
        axes.plot(panel.bounds, panel.values, "o", color=VERMILION, markersize=3, label="a run")
        axes.set_xscale("log", base=2)
        axes.set_xticks(panel.best_bounds, [f"{bound:g}" for bound in panel.best_bounds])
        axes.minorticks_off()
        axes.set_xlabel(panel.xlabel)
        axes.set_ylabel(panel.ylabel, parse_math=False)
    grid[0].legend(loc="best")
    return figure
