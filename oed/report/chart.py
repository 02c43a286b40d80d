"""Interactive figures of a page: Plotly's JSON, as small as a screen needs it."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.report.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION
from oed.report.envelope import envelope

Trace = Mapping[str, Any]

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY)
ROW, TITLE = 120, 24  # [px] of a panel with its title, and of the title
TOP, BOTTOM = 40, 46  # [px] for legend and abscissa
BARE_TOP = 12  # [px] where there is no legend
POINTS = 180_000  # on a page: 2 MB of text
LINE_POINTS = 4_000  # along a line: five times the pixels of a screen
THINNED = (
    "Long signals are drawn as the least and the greatest sample of each short interval, so that "
    "every peak is kept; drag to zoom, double-click to return."
)
_AXIS = {
    "gridcolor": "#E4E4E4",
    "zerolinecolor": GREY,
    "automargin": True,
    "title": {"standoff": 6},
}
_LAYOUT = {
    "margin": {"l": 8, "r": 8, "t": TOP, "b": BOTTOM},
    "font": {"family": "system-ui, sans-serif", "size": 12, "color": "#1d2329"},
    "paper_bgcolor": "#fff",
    "plot_bgcolor": "#fff",
    "hovermode": "closest",
    "legend": {"orientation": "h", "x": 0, "y": 1, "yref": "container", "yanchor": "top"},
}


@dataclass(frozen=True)
class Chart:
    """A figure that can be zoomed and tells the values under the pointer.

    Attributes:
        traces: As Plotly takes them; NumPy arrays may stand for numbers.
        axes: Layout of the axes, and what else differs from the layout of all charts.
        caption: What it shows; also read out in its place.
        height: [px]
    """

    traces: Sequence[Trace]
    axes: Mapping[str, Any]
    caption: str
    height: int
    kind: ClassVar[str] = "chart"

    @property
    def figure(self) -> dict[str, Any]:
        """Plotly's figure: data and layout."""
        given = {
            key: {**_AXIS, **value} if "axis" in key else value for key, value in self.axes.items()
        }
        return {"data": list(self.traces), "layout": {**_LAYOUT, "height": self.height, **given}}

    @property
    def json(self) -> str:
        """The figure as text that may stand in a script element."""
        text = json.dumps(self.figure, default=_packed, separators=(",", ":"), allow_nan=False)
        return text.replace("<", "\\u003c")


def plain(text: str) -> str:
    """A name as Plotly shows it letter by letter, not as the markup that it may look like."""
    return html.escape(text, quote=False)


def points_for(lines: int) -> int:
    """Points that each of the lines of a page may have."""
    return min(LINE_POINTS, POINTS // max(lines, 1))


def line(
    x: Float[ndarray, " samples"],
    y: Float[ndarray, " samples"],
    points: int,
    **more: Any,  # keys of Plotly's trace
) -> Trace:
    """A line of bounded size that keeps every peak.

    Args:
        x: (N,) any unit; NaN in `y` is a gap.
        y: (N,) any unit.
        points: At most so many.
        more: Further keys of the trace.
    """
    x, y = envelope(x, y, max(points // 2, 1))
    return {"type": "scatter", "mode": "lines", "x": _single(x), "y": _single(y), **more}


def stacked_panels(
    titles: Sequence[str], xlabel: str, *, has_legend: bool = True
) -> tuple[dict[str, Any], int]:
    """Axes of panels one below the other that share their abscissa, and the height [px].

    Args:
        titles: One a panel, from the top; its traces take `yaxis` of `panel_axis`.
        xlabel: Of the common abscissa.
        has_legend: Whether room is left for one.
    """
    top_margin = TOP if has_legend else BARE_TOP
    count = len(titles)
    axes: dict[str, Any] = {"hovermode": "x"}
    notes = []
    for k, title in enumerate(titles):
        bottom = (count - 1 - k) / count
        top = bottom + (ROW - TITLE) / (ROW * count)
        name = "yaxis" if k == 0 else f"yaxis{k + 1}"
        axes[name] = {"domain": [bottom, top], "nticks": 5}
        notes.append(
            {"text": plain(title), "x": 0, "y": top, "xref": "paper", "yref": "paper"}
            | {"xanchor": "left", "yanchor": "bottom", "showarrow": False}
        )
    axes["xaxis"] = {"title": {"text": plain(xlabel)}, "anchor": panel_axis(count - 1)}
    axes["margin"] = {**_LAYOUT["margin"], "t": top_margin}
    return {**axes, "annotations": notes}, top_margin + BOTTOM + ROW * count


def panel_axis(panel: int) -> str:
    """What a trace calls the ordinate of a panel, counted from 0 at the top."""
    return "y" if panel == 0 else f"y{panel + 1}"


def _single(values: ndarray) -> ndarray:
    """In single precision: seven digits are more than a screen shows."""
    return np.asarray(values, dtype=np.float32)


def _packed(value: object) -> dict[str, Any] | float:
    """An array as Plotly reads it from text: its bytes in base64; NaN is a gap there."""
    if isinstance(value, np.generic):
        return value.item()
    if not isinstance(value, ndarray) or value.dtype.kind != "f":
        raise TypeError(f"{type(value).__name__} is no part of a figure")
    kind = f"f{value.dtype.itemsize}"
    content = base64.b64encode(np.ascontiguousarray(value).astype(f"<{kind}").tobytes())
    packed: dict[str, Any] = {"dtype": kind, "bdata": content.decode("ascii")}
    return packed if value.ndim == 1 else {**packed, "shape": ", ".join(map(str, value.shape))}
