"""Pictures of a diagnosis: errors before and after, what the residual depends on, its spectrum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill

import matplotlib as mpl
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from oed.report.panels import legend_above, titled_panels
from oed.report.style import BLUE, GREY, STYLE, VERMILION

MOST_PANELS = 9  # strongest dependences that a reader looks at
FLOOR = "noise floor"
TITLE = 26  # characters across a third of the page
UNVISITED = "#D8D8D8"  # no colour of a map
SINCE = (("before", VERMILION), ("after", BLUE))


@dataclass(frozen=True)
class Curve:
    """Mean residual in B bins of a coordinate.

    Attributes:
        centre: (B,) of each bin, in the coordinate's unit.
        mean: (B,) residual there, in the joint's unit.
        error: (B,) standard error of that mean.
    """

    centre: Float[ndarray, " bins"]
    mean: Float[ndarray, " bins"]
    error: Float[ndarray, " bins"]


@dataclass(frozen=True)
class ResidualPanel:
    """The residual of one joint over one coordinate.

    Attributes:
        joint: Name of the joint.
        unit: Of its residual, "N m" or "N".
        coordinate: In words, with its unit.
        floor: Noise floor of the joint, in `unit`.
        before: Of the base model.
        after: Of the augmented one.
    """

    joint: str
    unit: str
    coordinate: str
    floor: float
    before: Curve
    after: Curve


@mpl.rc_context(STYLE)
def plot_dependences(shown: Sequence[ResidualPanel]) -> Figure:
    """Mean residual over coordinates, before and after, with two standard errors.

    Args:
        shown: Strongest first; no more than `MOST_PANELS` are drawn.

    Raises:
        ValueError: If there is none.
    """
    shown = shown[:MOST_PANELS]
    figure, panels = titled_panels([f"{s.joint} [{s.unit}]" for s in shown], "mean residual")
    for panel, s in zip(panels, shown, strict=True):
        panel.axhspan(-s.floor, s.floor, color="#EEEEEE", zorder=0, label=FLOOR)
        for (label, colour), curve in zip(SINCE, (s.before, s.after), strict=True):
            low, high = curve.mean - 2 * curve.error, curve.mean + 2 * curve.error
            panel.fill_between(curve.centre, low, high, color=colour, alpha=0.25, linewidth=0)
            panel.plot(curve.centre, curve.mean, color=colour, label=label)
        panel.set_xlabel(s.coordinate, fontsize=7.0)
    legend_above(figure, panels[0])
    return figure


@dataclass(frozen=True)
class AdditionPanel:
    """What one addition does.

    Attributes:
        title: Joint and the addition's name.
        unit: Of the joint's residual, "N m" or "N".
    """

    title: str
    unit: str


@dataclass(frozen=True)
class CurvePanel(AdditionPanel):
    """What one addition does over one coordinate.

    Attributes:
        coordinate: In words, with its unit.
        missing: Residual without the addition.
        given: What the addition gives of it.
    """

    coordinate: str
    missing: Curve
    given: Curve


@dataclass(frozen=True)
class MapPanel(AdditionPanel):
    """What one addition does over two coordinates.

    Attributes:
        coordinates: In words, with their units.
        edges: Of the cells, one array a coordinate.
        given: (C, C) torque in each cell, first coordinate first; NaN where there is none.
    """

    coordinates: tuple[str, str]
    edges: tuple[Float[ndarray, " edges"], Float[ndarray, " edges"]]
    given: Float[ndarray, "cells cells"]


@mpl.rc_context(STYLE)
def plot_contributions(shown: Sequence[CurvePanel | MapPanel]) -> Figure:
    """What each addition gives, over the coordinates on which it depends.

    Raises:
        ValueError: If there is none.
    """
    titles = [fill(s.title, TITLE, break_long_words=False) for s in shown]
    figure, panels = titled_panels(titles, "")
    for panel, s in zip(panels, shown, strict=True):
        panel.title.set_fontsize(7.5)
        if isinstance(s, CurvePanel):
            _draw_curve(panel, s)
        else:
            _draw_map(figure, panel, s)
    curves = [p for p, s in zip(panels, shown, strict=True) if isinstance(s, CurvePanel)]
    if curves:
        legend_above(figure, curves[0])
    return figure


def _draw_curve(panel: Axes, shown: CurvePanel) -> None:
    missing, given = shown.missing, shown.given
    panel.axhline(0.0, color="#CCCCCC", linewidth=0.6, zorder=0)
    panel.errorbar(
        missing.centre,
        missing.mean,
        yerr=2 * missing.error,
        color=VERMILION,
        marker="o",
        markersize=2.5,
        linestyle="none",
        label="residual without it",
    )
    panel.plot(given.centre, given.mean, color=BLUE, label="what it gives")
    panel.set_xlabel(shown.coordinate, fontsize=7.0)
    panel.set_ylabel(f"[{shown.unit}]", fontsize=7.0)


def _draw_map(figure: Figure, panel: Axes, shown: MapPanel) -> None:
    largest = float(np.nanmax(np.abs(shown.given), initial=0.0)) or 1.0
    panel.set_facecolor(UNVISITED)
    panel.grid(visible=False)
    drawn = panel.pcolormesh(
        *shown.edges, shown.given.T, cmap="RdBu_r", vmin=-largest, vmax=largest, rasterized=True
    )
    figure.colorbar(drawn, ax=panel).set_label(f"[{shown.unit}]", fontsize=7.0)
    first, second = shown.coordinates
    panel.set_xlabel(first, fontsize=7.0)
    panel.set_ylabel(second, fontsize=7.0)


@mpl.rc_context(STYLE)
def plot_spectra(
    frequency: Float[ndarray, " frequencies"],
    before: Float[ndarray, "frequencies joints"],
    after: Float[ndarray, "frequencies joints"],
    *,
    floor: Float[ndarray, " joints"],
    cutoff: float,
    joint_names: Sequence[str],
    units: Sequence[str],
) -> Figure:
    """Amplitude density of the residual before and after, joint by joint.

    The noise floor is drawn as if it were white from 0 to the band's edge.

    Args:
        frequency: (F,) [Hz].
        before: (F, n) power density of the base model's residual [unit²/Hz].
        after: (F, n) the same of the augmented model's.
        floor: (n,) standard deviation of the noise in the band [unit].
        cutoff: Edge of the analysis band [Hz].
        joint_names: (n,) names.
        units: (n,) unit of each joint's residual, "N m" or "N".
    """
    titles = [f"{name} [{unit}/√Hz]" for name, unit in zip(joint_names, units, strict=True)]
    figure, panels = titled_panels(titles, "residual, amplitude density")
    for j, panel in enumerate(panels):
        for (label, colour), power in zip(SINCE, (before, after), strict=True):
            panel.semilogy(frequency[1:], np.sqrt(power[1:, j]), color=colour, label=label)
        level = float(floor[j]) / np.sqrt(cutoff)
        panel.plot([0.0, cutoff], [level, level], color=GREY, linestyle="--", label=FLOOR)
        panel.axvline(cutoff, color=GREY, linestyle=":", label="edge of the analysis band")
        panel.set_xlabel("frequency [Hz]")
        _three_decades(panel)
    legend_above(figure, panels[0])
    return figure


@mpl.rc_context(STYLE)
def plot_proof(
    roles: Mapping[str, tuple[Float[ndarray, "joints 3"], Float[ndarray, "joints 3"]]],
    floor: Float[ndarray, " joints"],
    joint_names: Sequence[str],
    units: Sequence[str],
) -> Figure:
    """Error before and after on each kind of recording, with intervals and the noise floor.

    Args:
        roles: For each role (value, lower, upper) of every joint before and after [unit].
        floor: (n,) noise floor [unit].
        joint_names: (n,) names.
        units: (n,) unit of each joint's error, "N m" or "N".
    """
    titles = [f"{name} [{unit}]" for name, unit in zip(joint_names, units, strict=True)]
    figure, panels = titled_panels(titles, "rms error")
    places = np.arange(len(roles))
    for j, panel in enumerate(panels):
        panel.axhline(floor[j], color=GREY, linestyle="--", label=FLOOR)
        for when, ((label, colour), shift) in enumerate(zip(SINCE, (-0.14, 0.14), strict=True)):
            value, lower, upper = np.stack([errors[when][j] for errors in roles.values()], axis=1)
            panel.errorbar(
                places + shift,
                value,
                yerr=np.maximum([value - lower, upper - value], 0.0),
                color=colour,
                marker="o",
                markersize=3,
                linestyle="none",
                label=label,
            )
        panel.set_xticks(places, list(roles))
        panel.set_xlim(-0.5, len(roles) - 0.5)
        panel.set_ylim(bottom=0.0)
    legend_above(figure, panels[0])
    return figure


def _three_decades(panel: Axes) -> None:
    """Keep the flank beyond the band from squeezing what lies within it."""
    lower, upper = panel.get_ylim()
    panel.set_ylim(bottom=max(lower, upper / 1e3))
