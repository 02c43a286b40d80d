"""One panel a joint, time or frequency shared: the layout of the torque and residual figures."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oed.report.style import COLUMN, PAGE, PAGE_HEIGHT, new_figure

_ONE_COLUMN_UP_TO = 3  # joints; more are set in two columns across the page


def joint_grid(
    joint_names: Sequence[str], *, xlabel: str, ylabel: str, sharey: bool = False
) -> tuple[Figure, list[Axes]]:
    """A figure with one titled panel a joint.

    Args:
        joint_names: (n,) titles, in the order of the columns.
        xlabel: Label below the lowest panel of each column.
        ylabel: Label of the whole figure's ordinate.
        sharey: Whether all panels have one ordinate.

    Returns:
        The figure and its n panels.

    Raises:
        ValueError: If there is no joint.
    """
    n = len(joint_names)
    if n == 0:
        raise ValueError("no joint to draw")
    columns = 1 if n <= _ONE_COLUMN_UP_TO else 2
    rows = -(-n // columns)
    width = COLUMN if columns == 1 else PAGE
    figure = new_figure(width, min(0.55 + 1.25 * rows, PAGE_HEIGHT))
    grid = figure.subplots(rows, columns, sharex=True, sharey=sharey, squeeze=False)
    panels = list(grid.ravel())
    for spare in panels[n:]:
        spare.remove()
    for index, (panel, name) in enumerate(zip(panels[:n], joint_names, strict=True)):
        panel.set_title(name, parse_math=False)
        if index + columns >= n:  # nothing below it
            panel.set_xlabel(xlabel)
            panel.tick_params(labelbottom=True)
        if index // columns < rows - 1:
            # The empty place below has room for its labels: they must not part the rows.
            panel.xaxis.set_in_layout(False)
    figure.supylabel(ylabel, fontsize=8.0)
    return figure, panels[:n]
