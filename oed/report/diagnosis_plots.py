"""Pictures of a diagnosis: errors before and after, and what each addition gives."""

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

from oed.report.panels import COLUMNS, legend_above, titled_panels
from oed.report.style import BLUE, GREY, STYLE, VERMILION

FLOOR = "noise floor"
TITLE = 32  # characters across a third of the page
NARROW_TITLE = 44  # characters across a column
PROOF = "Error of the base model and with what was added, 95 % block bootstrap."
ADDITIONS = (
    "Each over the coordinate that tells most of it. Dots: mean of what is left without it, with two "
    "standard errors. Line: what it gives of that."
)
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
class CurvePanel:
    """What one addition does over one coordinate.

    Attributes:
        title: Joint and the addition's name.
        unit: Of the joint's residual, "N m" or "N".
        coordinate: In words, with its unit.
        is_along: Whether torque is counted in the direction in which the joint moves.
        missing: Residual without the addition.
        given: What the addition gives of it.
    """

    title: str
    unit: str
    coordinate: str
    is_along: bool
    missing: Curve
    given: Curve


@mpl.rc_context(STYLE)
def plot_contributions(shown: Sequence[CurvePanel], *, narrow: bool = False) -> Figure:
    """What each addition gives, over the coordinates on which it depends.

    Args:
        shown: A panel each.
        narrow: Whether it is for a narrow screen, one panel below the other.

    Raises:
        ValueError: If there is none.
    """
    across = NARROW_TITLE if narrow else TITLE * COLUMNS // min(COLUMNS, max(1, len(shown)))
    titles = [fill(s.title, across, break_long_words=False) for s in shown]
    figure, panels = titled_panels(titles, "", narrow=narrow)
    for panel, s in zip(panels, shown, strict=True):
        panel.title.set_fontsize(7.5)
        _draw_curve(panel, s)
    legend_above(figure, panels[0])
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
    way = "along the motion " if shown.is_along else ""
    panel.set_ylabel(f"{way}[{shown.unit}]", fontsize=7.0)


@mpl.rc_context(STYLE)
def plot_proof(
    roles: Mapping[str, tuple[Float[ndarray, "joints 3"], Float[ndarray, "joints 3"]]],
    floor: Float[ndarray, " joints"],
    joint_names: Sequence[str],
    units: Sequence[str],
    *,
    narrow: bool = False,
) -> Figure:
    """Error before and after on each kind of recording, with intervals and the noise floor.

    Args:
        roles: For each role (value, lower, upper) of every joint before and after [unit].
        floor: (n,) noise floor [unit].
        joint_names: (n,) names.
        units: (n,) unit of each joint's error, "N m" or "N".
        narrow: Whether it is for a narrow screen, one panel below the other.
    """
    titles = [f"{name} [{unit}]" for name, unit in zip(joint_names, units, strict=True)]
    figure, panels = titled_panels(titles, "rms error", narrow=narrow)
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
