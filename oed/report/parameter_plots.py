"""Estimated parameters: how they settle, and how well they are known (Calafiore 2001, figure 4)."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy import ndarray

from oed.report.style import BLUE, COLUMN, GREY, PAGE, PAGE_HEIGHT, STYLE, VERMILION, new_figure

_POINTS = 600  # along each small panel: more than it has pixels in print
_SETTLED = 0.15  # share of the run before which estimates may leave the panel
_ROW = 0.165  # [in] height of one interval


@mpl.rc_context(STYLE)
def plot_parameter_convergence(
    samples: Int[ndarray, " steps"],
    estimates: Float[ndarray, "steps parameters"],
    intervals: Float[ndarray, "steps parameters 2"],
    names: Sequence[str],
    units: Sequence[str],
) -> Figure:
    """Recursive estimates and their intervals against the samples used (figure 4).

    The ordinate fits the estimates after the first 15 % of the run: those from a few
    samples can be larger by orders of magnitude and would flatten the rest.

    Args:
        samples: (S,) number of samples used, increasing.
        estimates: (S, p) in the units given.
        intervals: (S, p, 2) lower and upper bound.
        names: (p,) names or expressions.
        units: (p,) units.

    Raises:
        ValueError: If there is not one name and one unit a parameter.
    """
    p = estimates.shape[1]
    _require_labels(names, units, p)
    columns = 2 if p <= 4 else 4 if p <= 32 else 6
    rows = -(-p // columns)
    width = COLUMN if columns == 2 else PAGE
    figure = new_figure(width, min(0.5 + 1.05 * rows, PAGE_HEIGHT))
    panels = list(figure.subplots(rows, columns, sharex=True, squeeze=False).ravel())
    # A longer name than its panel would run into the next one.
    letters = 26 if columns < 6 else 15
    size = 7.0 if columns < 6 else 6.0
    steps = np.unique(np.linspace(0, len(samples) - 1, _POINTS).round().astype(int))
    # Small panels have no room for five digits.
    unit, label = (1000, "samples used [thousands]") if samples[-1] >= 5000 else (1, "samples used")
    for k, panel in enumerate(panels[:p]):
        _draw_convergence(panel, samples[steps] / unit, estimates[steps, k], intervals[steps, k])
        title = shortened(f"{names[k]} [{units[k]}]", names[k], letters)
        panel.set_title(title, fontsize=size, parse_math=False)
        panel.tick_params(labelsize=size, labelbottom=k + columns >= p)
    for spare in panels[p:]:
        spare.remove()
    figure.supxlabel(label, fontsize=8.0)
    return figure


@mpl.rc_context(STYLE)
def plot_parameter_intervals(
    names: Sequence[str],
    values: Float[ndarray, " parameters"],
    lower: Float[ndarray, " parameters"],
    upper: Float[ndarray, " parameters"],
    units: Sequence[str],
) -> Figure:
    """Estimates with their intervals, one panel a unit.

    Args:
        names: (p,) names or expressions.
        values: (p,) estimates.
        lower: (p,) lower bounds of the intervals.
        upper: (p,) upper bounds.
        units: (p,) units.

    Raises:
        ValueError: If there is not one name and one unit a parameter.
    """
    _require_labels(names, units, len(values))
    groups = {unit: [k for k, u in enumerate(units) if u == unit] for unit in dict.fromkeys(units)}
    columns = _balanced(groups, 1 if len(values) <= 24 else 2)
    tallest = max(sum(len(groups[unit]) + 4 for unit in column) for column in columns)
    figure = new_figure(COLUMN if len(columns) == 1 else PAGE, 0.2 + _ROW * tallest)
    parts = figure.subfigures(1, len(columns), squeeze=False)[0]
    for part, column in zip(parts, columns, strict=True):
        heights = [len(groups[unit]) + 1.0 for unit in column]
        panels = part.subplots(
            len(column), 1, squeeze=False, gridspec_kw={"height_ratios": heights}
        )
        for panel, unit in zip(panels.ravel(), column, strict=True):
            chosen = groups[unit]
            _draw_intervals(panel, values[chosen], lower[chosen], upper[chosen])
            labels = [shortened(names[k], names[k], 28) for k in chosen]
            panel.set_yticks(range(len(chosen)), labels, parse_math=False)
            panel.set_xlabel(f"[{unit}]", parse_math=False)
    return figure


def shortened(text: str, name: str, letters: int) -> str:
    """The text if it fits, else the name if that fits, else its beginning and an ellipsis."""
    if len(text) <= letters:
        return text
    return name if len(name) <= letters else name[: letters - 1].rstrip() + "…"


def _draw_convergence(
    panel: Axes,
    samples: Float[ndarray, " steps"],
    estimate: Float[ndarray, " steps"],
    interval: Float[ndarray, "steps 2"],
) -> None:
    panel.fill_between(samples, interval[:, 0], interval[:, 1], color=BLUE, alpha=0.22, linewidth=0)
    panel.plot(samples, estimate, color=BLUE)
    panel.axhline(estimate[-1], color=GREY, linewidth=0.6, dashes=(4, 2), zorder=1)
    settled = samples >= samples[0] + _SETTLED * (samples[-1] - samples[0])
    shown = np.concatenate([interval[settled].ravel(), estimate[settled]])
    shown = shown[np.isfinite(shown)]
    if shown.size and np.ptp(shown) > 0:
        margin = 0.08 * np.ptp(shown)
        panel.set_ylim(shown.min() - margin, shown.max() + margin)
    panel.margins(x=0)
    panel.xaxis.set_major_locator(MaxNLocator(2))
    panel.yaxis.set_major_locator(MaxNLocator(3))


def _draw_intervals(
    panel: Axes,
    values: Float[ndarray, " chosen"],
    lower: Float[ndarray, " chosen"],
    upper: Float[ndarray, " chosen"],
) -> None:
    rows = np.arange(len(values))
    panel.axvline(0.0, color=GREY, linewidth=0.7)
    panel.hlines(rows, lower, upper, color=BLUE, linewidth=1.6)
    # An interval that holds zero is not told from zero: its marker is hollow.
    unsure = (lower <= 0) & (upper >= 0)
    panel.scatter(values[~unsure], rows[~unsure], s=11, color=BLUE, zorder=3)
    panel.scatter(
        values[unsure], rows[unsure], s=11, facecolor="white", edgecolor=VERMILION, zorder=3
    )
    panel.set_ylim(len(values) - 0.4, -0.6)
    panel.tick_params(axis="y", length=0)
    panel.grid(visible=False, axis="y")


def _balanced(groups: dict[str, list[int]], count: int) -> list[list[str]]:
    """The units in columns of about equal height, in order."""
    units = list(groups)
    if count == 1 or len(units) == 1:
        return [units]
    heights = [len(groups[unit]) + 4 for unit in units]
    split = min(range(1, len(units)), key=lambda k: max(sum(heights[:k]), sum(heights[k:])))
    return [units[:split], units[split:]]


def _require_labels(names: Sequence[str], units: Sequence[str], parameters: int) -> None:
    if not len(names) == len(units) == parameters:
        raise ValueError(f"{len(names)} names, {len(units)} units, {parameters} parameters")
