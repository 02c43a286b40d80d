"""Feasible estimates in pictures: the weight's curve, margins, and parameters beside their prior.

Every function draws what it is given and returns the figure.
"""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from numpy import ndarray

from oed.report.style import BLUE, COLUMN, GREEN, GREY, PAGE, STYLE, VERMILION, new_figure


@mpl.rc_context(STYLE)
def plot_weight_curve(
    weights: Float[ndarray, " w"],
    held_out: Float[ndarray, "w folds"],
    fitted: Float[ndarray, "w folds"],
    *,
    best: int,
    chosen: int,
    least_squares: float,
) -> Figure:
    """Held-out and fitted error against the weight of the pull to the reference.

    Args:
        weights: (w,) tried, increasing.
        held_out: (w, folds) mean squared weighted residual of the fold left out.
        fitted: (w, folds) the same of the rest.
        best: Index of the least held-out error.
        chosen: Index of the weight that was taken.
        least_squares: Held-out error of plain least squares, mean over folds.
    """
    figure = new_figure(COLUMN, 2.5)
    panel = figure.subplots()
    folds = held_out.shape[1]
    panel.set_xscale("log")
    for errors, colour, label in (
        (held_out, BLUE, "held out"),
        (fitted, GREY, "fitted"),
    ):
        panel.errorbar(
            weights,
            errors.mean(axis=1),
            yerr=(errors - errors[best]).std(axis=1, ddof=1) / np.sqrt(folds),
            color=colour,
            marker="o",
            markersize=3,
            capsize=2,
            label=label,
        )
    panel.axhline(least_squares, color=VERMILION, dashes=(4, 2), label="plain LS, held out")
    panel.axvline(weights[chosen], color=GREEN, dashes=(1, 1), label="chosen")
    finite = held_out.mean(axis=1)
    lowest = np.nanmin([np.nanmin(fitted.mean(axis=1)), np.nanmin(finite), least_squares])
    # A strong pull is far off: what matters is the bottom of the curve.
    top = max(least_squares, 1.5 * np.nanmin(finite))
    panel.set_ylim(lowest - 0.08 * (top - lowest), top + 0.05 * (top - lowest))
    panel.set_xlabel("weight of the pull to the reference")
    panel.set_ylabel("rms residual, mean of joints\n/ plain LS, fitted")
    figure.legend(loc="outside upper center", ncols=4, columnspacing=1.0, handletextpad=0.4)
    return figure


@mpl.rc_context(STYLE)
def plot_link_margins(
    links: Sequence[str],
    relative: Float[ndarray, " links"],
    floor: float,
) -> Figure:
    """Least eigenvalue of each link's pseudo-inertia, relative to its reference body.

    Args:
        links: (n,) names.
        relative: (n,) margins of the feasible estimate.
        floor: The margin that was demanded.
    """
    figure = new_figure(COLUMN, max(1.2, 0.55 + 0.22 * len(links)))
    panel = figure.subplots()
    place = np.arange(len(links))[::-1]
    panel.set_xscale("log")
    panel.hlines(place, floor, relative, color=GREY, linewidth=1.0)
    panel.plot(relative, place, "o", color=BLUE, markersize=4)
    panel.axvline(floor, color=VERMILION, dashes=(4, 2), label="demanded")
    panel.set_yticks(place, links, parse_math=False)
    panel.set_xlim(floor / 2, max(2.0, 1.5 * float(relative.max())))
    panel.set_xlabel("least eigenvalue / reference body")
    figure.legend(loc="outside upper right")
    return figure


@mpl.rc_context(STYLE)
def plot_residual_comparison(
    labels: Sequence[str],
    plain: Float[ndarray, " cases"],
    feasible: Float[ndarray, " cases"],
    *,
    ylabel: str,
) -> Figure:
    """Residuals of the plain and the feasible estimate side by side.

    Args:
        labels: Of the cases.
        plain: Residual of plain least squares.
        feasible: Residual of the feasible estimate.
        ylabel: What the residual is, with its unit.
    """
    figure = new_figure(min(PAGE, max(COLUMN, 0.42 * len(labels) + 0.8)), 2.3)
    panel = figure.subplots()
    place = np.arange(len(labels))
    panel.bar(place - 0.2, plain, 0.38, color=GREY, label="plain least squares")
    panel.bar(place + 0.2, feasible, 0.38, color=BLUE, label="feasible")
    panel.set_xticks(place, labels, rotation=40, ha="right", parse_math=False)
    panel.set_ylabel(ylabel)
    panel.grid(visible=False, axis="x")
    figure.legend(loc="outside upper right", ncols=2)
    return figure
