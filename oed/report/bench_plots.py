"""Pictures of the undeclared-effect bench: what was hidden against what was said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter
from numpy import ndarray

from oed.report.style import BLUE, COLUMN, GREY, PAGE, STYLE, VERMILION, new_figure


@mpl.rc_context(STYLE)
def plot_confusion(counts: Mapping[tuple[str, str], int]) -> Figure:
    """How often each name was given where each effect was hidden.

    Args:
        counts: (hidden, named) -> number of data sets.
    """
    hidden = sorted({pair[0] for pair in counts})
    named = sorted({pair[1] for pair in counts}, key=lambda name: (name not in hidden, name))
    matrix = np.array([[counts.get((h, n), 0) for n in named] for h in hidden])
    figure = new_figure(PAGE, 1.6 + 0.19 * len(hidden))
    axes = figure.add_subplot()
    shares = matrix / np.maximum(matrix.sum(axis=1, keepdims=True), 1)
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for (i, j), count in np.ndenumerate(matrix):
        if count:
            axes.text(
                j,
                i,
                str(count),
                ha="center",
                va="center",
                fontsize=6.5,
                color="white" if shares[i, j] > 0.6 else "black",
            )
    axes.set_xticks(range(len(named)), [name.replace("_", " ") for name in named], rotation=90)
    axes.set_yticks(range(len(hidden)), [name.replace("_", " ") for name in hidden])
    axes.set(xlabel="named", ylabel="hidden")
    axes.grid(visible=False)
    return figure


@mpl.rc_context(STYLE)
def plot_detection(bins: Sequence[Mapping[str, float | int]]) -> Figure:
    """Share of effects noticed and rightly named against their size.

    Args:
        bins: Each with "median" size in units of the noise, "noticed" and "right" shares, and
            the interval of the latter from "lower" to "upper".
    """
    figure = new_figure(COLUMN, 2.4)
    axes = figure.add_subplot()
    size, noticed = (np.array([float(b[key]) for b in bins]) for key in ("median", "noticed"))
    axes.plot(size, noticed, "o--", color=GREY, label="noticed", markersize=3.5)
    _draw_right(axes, size, bins, "o-", "right class")
    axes.set_xscale("log")
    axes.set(xlabel="size of the effect / noise (rms)", ylabel="share", ylim=(-0.03, 1.03))
    axes.legend(loc="lower right")
    return figure


@mpl.rc_context(STYLE)
def plot_reliability(bins: Sequence[Mapping[str, float | int | str]]) -> Figure:
    """Share of names that are right against the probability that was stated for them.

    Args:
        bins: Each with its ends "from" and "to", how many "names" it has, the mean that was "stated",
            the share "right", and the interval of the latter from "lower" to "upper".
    """
    figure = new_figure(COLUMN, 2.4)
    axes = figure.add_subplot()
    stated, place = [float(b["stated"]) for b in bins], np.arange(len(bins))
    _draw_right(axes, place, bins, "o", "right")
    axes.plot(place, stated, "_", color=VERMILION, markersize=14, label="stated")
    for x, b in zip(place, bins, strict=True):
        axes.annotate(str(b["names"]), (x, 0.0), ha="center", fontsize=6.5, color=GREY)
    axes.set_xticks(place, [f"{b['from']:g} to {b['to']:g}" for b in bins])
    axes.set(xlabel="stated probability (below: names)", ylabel="share right", ylim=(-0.03, 1.03))
    axes.set_xlim(-0.5, len(bins) - 0.5)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


def _draw_right(
    axes: Axes,
    place: Float[ndarray, " bins"] | Int[ndarray, " bins"],
    bins: Sequence[Mapping[str, float | int | str]],
    line: str,
    label: str,
) -> None:
    """The share right of each bin with its interval."""
    right, lower, upper = (
        np.array([float(b[key]) for b in bins]) for key in ("right", "lower", "upper")
    )
    spread = [right - lower, upper - right]
    axes.errorbar(
        place, right, spread, fmt=line, color=BLUE, label=label, markersize=3.5, elinewidth=0.7
    )


@mpl.rc_context(STYLE)
def plot_errors(groups: Sequence[str], ratios: Sequence[Sequence[float]]) -> Figure:
    """Test error after the diagnosis over the noise floor, a row a group.

    Args:
        groups: Names of the groups.
        ratios: For each group the ratios of its data sets.

    Raises:
        ValueError: If there is not one list a group.
    """
    if len(groups) != len(ratios):
        raise ValueError(f"{len(groups)} groups, {len(ratios)} lists of ratios")
    figure = new_figure(COLUMN, 0.9 + 0.25 * len(groups))
    axes = figure.add_subplot()
    for row, values in enumerate(ratios):
        axes.plot(values, [row] * len(values), "|", color=BLUE, markersize=6)
        axes.plot(np.median(values), row, "D", color=VERMILION, markersize=3.5)
    axes.axvline(1.0, color=GREY, linewidth=0.8)
    axes.set_xscale("log")
    for show in (axes.xaxis.set_major_formatter, axes.xaxis.set_minor_formatter):
        show(LogFormatter())  # 2, not 2 × 10⁰
    axes.set_yticks(range(len(groups)), [group.replace("_", " ") for group in groups])
    axes.set(xlabel="test error after / noise floor", ylim=(len(groups) - 0.5, -0.5))
    return figure
