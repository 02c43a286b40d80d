"""Pictures of a diagnosis: where the residual lives, its spectrum, and errors before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from numpy import ndarray

from oed.report.joint_grid import joint_grid
from oed.report.style import BLUE, COLUMN, GREY, PAGE, STYLE, VERMILION, new_figure

Curve = tuple[Float[ndarray, " bins"], Float[ndarray, " bins"], Float[ndarray, " bins"]]
MOST_PANELS = 16  # strongest dependences that a page can show


@mpl.rc_context(STYLE)
def plot_dependences(curves: Sequence[tuple[str, Curve, Curve]], floors: Sequence[float]) -> Figure:
    """Mean residual over coordinates, before and after, with two standard errors.

    Args:
        curves: Title, then (centre, mean, standard error) before and after; at most 16.
        floors: Noise floor of each panel's joint [N m].
    """
    shown = list(zip(curves, floors, strict=True))[:MOST_PANELS]
    columns = min(4, max(1, len(shown)))
    rows = max(1, -(-len(shown) // columns))
    figure = new_figure(PAGE, 0.4 + 1.45 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for spare in panels[len(shown) :]:
        spare.remove()
    for panel, ((title, before, after), floor) in zip(panels, shown, strict=False):
        panel.axhspan(-floor, floor, color="#EEEEEE", zorder=0)
        for curve, colour, label in ((before, VERMILION, "before"), (after, BLUE, "after")):
            centre, mean, error = curve
            panel.fill_between(
                centre, mean - 2 * error, mean + 2 * error, color=colour, alpha=0.25, linewidth=0
            )
            panel.plot(centre, mean, color=colour, label=label)
        panel.set_title(title, parse_math=False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2)
    figure.supylabel("mean residual [N m]; grey: noise floor", fontsize=8.0)
    return figure


@mpl.rc_context(STYLE)
def plot_spectra(
    frequency: Float[ndarray, " frequencies"],
    before: Float[ndarray, "frequencies joints"],
    after: Float[ndarray, "frequencies joints"],
    joint_names: Sequence[str],
) -> Figure:
    """Amplitude density of the residual before and after, joint by joint."""
    figure, panels = joint_grid(
        joint_names, xlabel="frequency [Hz]", ylabel="residual [N m/√Hz]", sharey=False
    )
    for j, panel in enumerate(panels):
        for power, colour, label in ((before, VERMILION, "before"), (after, BLUE, "after")):
            panel.semilogy(frequency[1:], np.sqrt(power[1:, j]), color=colour, label=label)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2)
    return figure


@mpl.rc_context(STYLE)
def plot_proof(
    roles: Mapping[str, tuple[Float[ndarray, "joints 3"], Float[ndarray, "joints 3"]]],
    floor: Float[ndarray, " joints"],
    joint_names: Sequence[str],
) -> Figure:
    """Error before and after on each kind of recording, with intervals and the noise floor.

    Args:
        roles: For each role (value, lower, upper) of every joint before and after [N m].
        floor: (n,) noise floor [N m].
        joint_names: (n,) names.
    """
    n = len(joint_names)
    figure = new_figure(max(COLUMN, 1.1 * n + 0.6), 2.2)
    panels = figure.subplots(1, n, squeeze=False)[0]
    names = list(roles)
    for j, panel in enumerate(panels):
        panel.axhline(floor[j], color=GREY, linestyle="--", label="noise floor")
        for k, role in enumerate(names):
            pairs = zip(
                roles[role], (VERMILION, BLUE), ("before", "after"), (-0.14, 0.14), strict=False
            )
            for values, colour, label, shift in pairs:
                value, lower, upper = values[j]
                panel.errorbar(
                    k + shift,
                    value,
                    yerr=[[max(value - lower, 0.0)], [max(upper - value, 0.0)]],
                    color=colour,
                    marker="o",
                    markersize=3,
                    linestyle="none",
                    label=label if k == 0 else None,
                )
        panel.set_xticks(range(len(names)), [name[:5] for name in names])
        panel.set_xlim(-0.5, len(names) - 0.5)
        panel.set_ylim(bottom=0.0)
        panel.set_title(joint_names[j], parse_math=False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=3)
    panels[0].set_ylabel("rms error [N m]")
    return figure
