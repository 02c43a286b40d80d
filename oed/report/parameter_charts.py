"""Estimated parameters: how they settle, and how well they are known (Calafiore 2001, figure 4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.report.chart import BOTTOM, COLOURS, TOP, Chart, plain
from oed.report.colours import BLACK, BLUE, VERMILION

LETTERS = 20  # of a name along the ordinate: a telephone leaves no room for more
INTERVAL = 20  # [px] a row
STEPS = 160  # along a line
SETTLED = 0.5  # share of the run before which estimates may leave the figure
CONVERGENCE = 380  # [px]


def interval_charts(
    names: Sequence[str],
    values: Float[ndarray, " parameters"],
    interval: Float[ndarray, "parameters 2"],
    units: Sequence[str],
    *,
    caption: str,
    file: Float[ndarray, " parameters"] | None = None,
) -> list[Chart]:
    """Estimates with their intervals, one chart a unit; hollow where the interval holds zero.

    Args:
        names: (p,) names or expressions.
        values: (p,) estimates.
        interval: (p, 2) lower and upper bounds.
        units: (p,) units.
        caption: What they show; the unit follows.
        file: (p,) values of the robot's file; NaN where it has none.
    """
    stated = np.full(len(values), np.nan) if file is None else file
    charts = []
    for unit in dict.fromkeys(units):
        chosen = np.array([k for k, u in enumerate(units) if u == unit])
        charts.append(
            _intervals(
                [str(names[k]) for k in chosen],
                values[chosen],
                interval[chosen],
                file=stated[chosen],
                unit=unit,
                caption=f"{caption} In {unit}; hollow where the interval holds zero.",
            )
        )
    return charts


def convergence_chart(
    samples: Int[ndarray, " steps"],
    estimates: Float[ndarray, "steps parameters"],
    std: Float[ndarray, "steps parameters"],
    names: Sequence[str],
    units: Sequence[str],
    *,
    caption: str,
) -> Chart:
    """Recursive estimates on their way to their final values, against the samples used (figure 4).

    The ordinate counts final standard deviations, so that all parameters fit one figure; it fits
    the latter half of the run, as estimates from a few samples are far off.

    Args:
        samples: (S,) number of samples used, increasing.
        estimates: (S, p) in the units given.
        std: (S, p) standard deviations.
        names: (p,) names or expressions.
        units: (p,) units.
        caption: What it shows.
    """
    steps = np.unique(np.linspace(0, len(samples) - 1, STEPS).round().astype(int))
    used = samples[steps].astype(np.float32)
    deviations = (estimates[steps] - estimates[-1]) / np.where(std[-1] > 0, std[-1], 1.0)
    traces = [
        {"type": "scatter", "mode": "lines", "x": used, "y": deviations[:, k].astype(np.float32)}
        | {"name": plain(name), "showlegend": False, "line": {"width": 1, "color": COLOURS[k % 8]}}
        | {"customdata": estimates[steps, k].astype(np.float32)}
        | {"hovertemplate": f"{plain(name)}: %{{customdata:.4g}} {units[k]} after %{{x:.0f}} samples<extra></extra>"}
        for k, name in enumerate(names)
    ]  # fmt: skip
    settled = deviations[used >= used[0] + SETTLED * (used[-1] - used[0])]
    reach = max(3.0, 1.1 * float(np.abs(settled).max()))
    axes = {
        "xaxis": {"title": {"text": "samples used"}},
        "yaxis": {"title": {"text": "from the final value [std]"}, "range": [-reach, reach]},
    }
    return Chart(traces, axes, caption, CONVERGENCE)


def _intervals(
    names: Sequence[str],
    values: Float[ndarray, " chosen"],
    interval: Float[ndarray, "chosen 2"],
    *,
    file: Float[ndarray, " chosen"],
    unit: str,
    caption: str,
) -> Chart:
    unsure = (interval[:, 0] <= 0) & (interval[:, 1] >= 0)
    rows = np.arange(float(len(names)))
    trace = {
        "type": "scatter",
        "mode": "markers",
        "x": values,
        "y": rows,
        "error_x": {
            "type": "data",
            "symmetric": False,
            "array": interval[:, 1] - values,
            "arrayminus": values - interval[:, 0],
            "color": BLUE,
            "thickness": 1.6,
            "width": 0,
        },
        "marker": {
            "size": 7,
            "color": ["#ffffff" if u else BLUE for u in unsure],
            "line": {"width": 1.2, "color": [VERMILION if u else BLUE for u in unsure]},
        },
        "text": [
            f"{plain(name)}: {value:.4g} {unit}<br>95 %: {low:.4g} to {high:.4g}"
            for name, value, (low, high) in zip(names, values, interval, strict=True)
        ],
        "hovertemplate": "%{text}<extra></extra>",
    }
    ticks = [plain(name if len(name) <= LETTERS else name[: LETTERS - 1] + "…") for name in names]
    axes = {
        "xaxis": {"title": {"text": f"[{unit}]"}},
        "yaxis": {"tickvals": rows, "ticktext": ticks, "range": [len(names) - 0.4, -0.6]}
        | {"showgrid": False, "zeroline": False},
        "margin": {"l": 8, "r": 8, "t": 12, "b": BOTTOM},
    }
    has = np.flatnonzero(np.isfinite(file)).tolist()
    of_file = {
        "type": "scatter",
        "mode": "markers",
        "x": file[has],
        "y": rows[has],
        "marker": {"symbol": "diamond-open", "size": 9, "color": BLACK},
        "text": [f"{plain(names[k])}: {file[k]:.4g} {unit} in the file" for k in has],
        "hovertemplate": "%{text}<extra></extra>",
    }
    traces = [of_file, trace] if has else [trace]
    axes["showlegend"] = False
    return Chart(traces, axes, caption, TOP + BOTTOM + INTERVAL * len(names))
