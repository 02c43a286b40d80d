"""Long signals drawn as short lines that keep every peak."""

from __future__ import annotations

from jaxtyping import Float
from matplotlib.axes import Axes
from numpy import ndarray

from oed.report.envelope import envelope


def draw_signal(
    axes: Axes,
    t: Float[ndarray, " samples"],
    y: Float[ndarray, " samples"],
    *,
    color: str,
    label: str,
    linewidth: float = 0.8,
    alpha: float = 1.0,
) -> None:
    """Draw a signal of any length as a line of bounded size."""
    t, y = envelope(t, y)
    axes.plot(t, y, color=color, label=label, linewidth=linewidth, alpha=alpha)
