"""Feasible estimates to look at: masses beside the file's, margins, residuals, the weight's curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.change_from_file import LinkChange
from oed.report.chart import BOTTOM, TOP, Chart, Trace, panel_axis, plain, stacked_panels
from oed.report.colours import BLUE, GREEN, GREY, VERMILION

BARS = 320  # [px]
LINK = 26  # [px] a row


def mass_chart(changes: Sequence[LinkChange]) -> Chart:
    """Mass of each link in the robot's file and as identified, with its interval.

    Args:
        changes: Of the links; their sum is left out, as it would dwarf them.
    """
    links = [change for change in changes if change.centre]
    names = [plain(change.link) for change in links]
    mass = np.array([change.mass.after for change in links])
    interval = np.array([change.mass.interval for change in links]).reshape(-1, 2)
    error = {
        "type": "data",
        "symmetric": False,
        "array": np.maximum(interval[:, 1] - mass, 0.0),
        "arrayminus": np.maximum(mass - interval[:, 0], 0.0),
    }
    told = "%{x}: %{y:.4g} kg"
    before = np.array([change.mass.before for change in links])
    traces = [_bars(names, before, "robot file", GREY, told)]
    traces.append({**_bars(names, mass, "identified", BLUE, told), "error_y": error})
    axes = {"yaxis": {"title": {"text": "mass [kg]"}}, "barmode": "group"}
    return Chart(traces, axes, "Mass of each link; bars of error are 95 % intervals.", BARS)


def centre_chart(changes: Sequence[LinkChange]) -> Chart:
    """Centre of mass of each link in the file and as identified, a panel an axis.

    Args:
        changes: Of the links; those without a centre are left out.
    """
    links = [change for change in changes if change.centre]
    names = [plain(change.link) for change in links]
    traces: list[Trace] = []
    for axis, letter in enumerate("xyz"):
        moved = [change.centre[axis] for change in links]
        before, after = np.array([[m.before, m.after] for m in moved]).reshape(-1, 2).T
        for label, colour, values in (
            ("robot file", GREY, before),
            ("identified", BLUE, after),
        ):
            told = f"%{{x}}: {letter} %{{y:.4f}} m"
            bars = _bars(names, values, label, colour, told)
            own = {"yaxis": panel_axis(axis), "legendgroup": label, "showlegend": axis == 0}
            traces.append({**bars, **own})
    axes, height = stacked_panels([f"{letter} [m]" for letter in "xyz"], "")
    axes |= {"barmode": "group", "hovermode": "closest"}
    return Chart(traces, axes, "Centre of mass of each link in its body frame.", height)


def margin_chart(links: Sequence[str], relative: Float[ndarray, " links"], floor: float) -> Chart:
    """Least eigenvalue of each link's pseudo-inertia, relative to its reference body.

    Args:
        links: (n,) names.
        relative: (n,) margins of the feasible estimate.
        floor: The margin that was demanded.
    """
    trace = {"type": "scatter", "mode": "markers", "x": relative, "y": [plain(n) for n in links]}
    trace |= {"marker": {"size": 9, "color": BLUE}}
    trace |= {"hovertemplate": "%{y}: %{x:.3g}<extra></extra>"}
    axes = {
        "xaxis": {"type": "log", "title": {"text": "least eigenvalue / reference body"}}
        | {"exponentformat": "power"},
        "yaxis": {"type": "category", "autorange": "reversed"},
        "shapes": [_mark("x", floor, VERMILION)],
        "margin": {"l": 8, "r": 8, "t": 12, "b": BOTTOM},
    }
    caption = (
        "Least eigenvalue of each pseudo-inertia, per reference body; the line is what is demanded."
    )
    return Chart([trace], axes, caption, TOP + BOTTOM + LINK * len(links))


def residual_comparison_chart(
    joints: Sequence[str],
    plain_rms: Float[ndarray, " joints"],
    feasible_rms: Float[ndarray, " joints"],
    *,
    label: str,
    caption: str,
) -> Chart:
    """Residuals of the plain and the feasible estimate side by side.

    Args:
        joints: (n,) names.
        plain_rms: (n,) of plain least squares.
        feasible_rms: (n,) of the feasible estimate.
        label: What the residual is, with its unit.
        caption: What it shows.
    """
    names = [plain(name) for name in joints]
    told = "%{x}: %{y:.4g}"
    traces = [
        _bars(names, plain_rms, "plain least squares", GREY, told),
        _bars(names, feasible_rms, "feasible", BLUE, told),
    ]
    axes = {"yaxis": {"title": {"text": plain(label)}}, "barmode": "group"}
    return Chart(traces, axes, caption, BARS)


def weight_chart(
    weights: Float[ndarray, " w"],
    held_out: Float[ndarray, "w folds"],
    fitted: Float[ndarray, "w folds"],
    *,
    best: int,
    chosen: int,
    least_squares: float,
) -> Chart:
    """Held-out and fitted error against the weight of the pull to the reference.

    Args:
        weights: (w,) tried, increasing.
        held_out: (w, folds) mean squared weighted residual of the fold left out.
        fitted: (w, folds) the same of the rest.
        best: Index of the least held-out error.
        chosen: Index of the weight that was taken.
        least_squares: Held-out error of plain least squares, mean over folds.
    """
    traces = []
    for errors, colour, name in ((held_out, BLUE, "held out"), (fitted, GREY, "fitted")):
        spread = (errors - errors[best]).std(axis=1, ddof=1) / np.sqrt(held_out.shape[1])
        bars = {"type": "data", "array": [float(s) if np.isfinite(s) else 0.0 for s in spread]}
        point = {"type": "scatter", "mode": "lines+markers", "name": name, "x": weights}
        traces.append(
            {**point, "y": errors.mean(axis=1), "error_y": bars, "line": {"color": colour}}
            | {"hovertemplate": "%{y:.4g} at weight %{x:.3g}"}
        )
    lowest = float(
        np.nanmin([np.nanmin(fitted.mean(1)), np.nanmin(held_out.mean(1)), least_squares])
    )
    # A strong pull is far off: what matters is the bottom of the curve.
    top = max(least_squares, 1.5 * float(np.nanmin(held_out.mean(axis=1))))
    edge = 0.08 * (top - lowest)
    axes = {
        "xaxis": {"type": "log", "title": {"text": "weight of the pull to the reference"}}
        | {"exponentformat": "power"},
        "yaxis": {"title": {"text": "error / plain, fitted"}, "range": [lowest - edge, top + edge]},
        "shapes": [
            _mark("y", least_squares, VERMILION),
            _mark("x", float(weights[chosen]), GREEN),
        ],
    }
    caption = (
        "Error of held-out and of fitted data; bars are standard errors of the difference to the "
        "best weight. Dashed: plain least squares on held-out data, and the weight chosen."
    )
    return Chart(traces, axes, caption, BARS)


def _bars(names: Sequence[str], values: ndarray, name: str, colour: str, told: str) -> Trace:
    return {"type": "bar", "x": list(names), "y": values, "name": name} | {
        "marker": {"color": colour}, "hovertemplate": told
    }  # fmt: skip


def _mark(axis: str, value: float, colour: str) -> dict[str, Any]:
    """A dashed line across the panel at a value of an axis."""
    other = "y" if axis == "x" else "x"
    return {
        "type": "line", f"{axis}0": value, f"{axis}1": value, f"{other}ref": "paper",
        f"{other}0": 0, f"{other}1": 1, "line": {"color": colour, "dash": "dash"},
    }  # fmt: skip
