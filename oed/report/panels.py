"""Small panels in rows across the page, at one scale whatever their number."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oed.report.style import PAGE, PAGE_HEIGHT, new_figure

_COLUMNS = 3
_ROW = 1.6  # [in] height with its labels


def page_panels(titles: Sequence[str], ylabel: str) -> tuple[Figure, list[Axes]]:
    """A figure as wide as the page with one titled panel each, at most three in a row.

    Args:
        titles: Of the panels.
        ylabel: Of the whole figure.

    Returns:
        The figure and a panel a title.

    Raises:
        ValueError: If there is no panel to draw.
    """
    if not titles:
        raise ValueError("no panel to draw")
    columns = min(_COLUMNS, len(titles))
    rows = -(-len(titles) // columns)
    figure = new_figure(PAGE, min(0.4 + _ROW * rows, PAGE_HEIGHT))
    grid = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for spare in grid[len(titles) :]:
        spare.remove()
    panels = grid[: len(titles)]
    for panel, title in zip(panels, titles, strict=True):
        panel.set_title(title, parse_math=False)
    figure.supylabel(ylabel, fontsize=8.0)
    return figure, panels


def legend_above(figure: Figure, panel: Axes) -> None:
    """What a panel's lines are, above all panels."""
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels))
