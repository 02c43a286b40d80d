"""Small panels in rows across the page, at one scale whatever their number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oed.report.style import COLUMN, PAGE, PAGE_HEIGHT, new_figure

ROW = 1.6  # [in] height of titled panels with their labels
COLUMNS = 3


def page_panels(
    count: int, *, columns: int, row: float, sharey: bool | Literal["row"] = False
) -> tuple[Figure, list[Axes]]:
    """A figure as wide as the page, its panels row by row.

    Args:
        count: Of panels.
        columns: Panels a row.
        row: Height of each [in].
        sharey: Whether all panels, or those of one row, have one ordinate.

    Raises:
        ValueError: If there is no panel to draw.
    """
    if count == 0:
        raise ValueError("no panel to draw")
    rows = -(-count // columns)
    figure = new_figure(PAGE, min(0.4 + row * rows, PAGE_HEIGHT))
    grid = list(figure.subplots(rows, columns, sharey=sharey, squeeze=False).ravel())
    for spare in grid[count:]:
        spare.remove()
    return figure, grid[:count]


def screen_panels(count: int, *, row: float) -> tuple[Figure, list[Axes]]:
    """A figure as wide as a column, its panels one below the other, as many as there are.

    Args:
        count: Of panels.
        row: Height of each [in].

    Raises:
        ValueError: If there is no panel to draw.
    """
    if count == 0:
        raise ValueError("no panel to draw")
    figure = new_figure(COLUMN, 0.4 + row * count)
    return figure, list(figure.subplots(count, 1, squeeze=False).ravel())


def titled_panels(
    titles: Sequence[str], ylabel: str, *, narrow: bool = False
) -> tuple[Figure, list[Axes]]:
    """A titled panel each, at most three in a row.

    Args:
        titles: Of the panels.
        ylabel: Of the whole figure.
        narrow: Whether panels stand one below the other, for a screen as wide as a telephone.

    Raises:
        ValueError: If there is no panel to draw.
    """
    if narrow:
        figure, panels = screen_panels(len(titles), row=ROW)
    else:
        columns = max(1, min(COLUMNS, len(titles)))
        figure, panels = page_panels(len(titles), columns=columns, row=ROW)
    for panel, title in zip(panels, titles, strict=True):
        panel.set_title(title, parse_math=False)
    figure.supylabel(ylabel, fontsize=8.0)
    return figure, panels


def legend_above(figure: Figure, panel: Axes) -> None:
    """What a panel's lines are, above all panels."""
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels))
