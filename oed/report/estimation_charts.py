"""Torque, residual and its spectrum, joint by joint, to look into (Calafiore 2001, figures 5, 6, 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.report.chart import (
    BOTTOM,
    COLOURS,
    TOP,
    Chart,
    line,
    panel_axis,
    plain,
    stacked_panels,
)
from oed.report.colours import BLACK, BLUE, GREEN, GREY, VERMILION

SPECTRUM = 320  # [px]
BAND = {"color": VERMILION, "width": 1.2}
BAND_OF_SEVERAL = {"color": BLACK, "width": 1.0, "dash": "dot"}  # beside lines of all colours


def torque_chart(
    t: Float[ndarray, " samples"],
    measured: Float[ndarray, "samples joints"],
    predicted: Mapping[str, Float[ndarray, "samples joints"]],
    joints: Sequence[str],
    units: Sequence[str],
    *,
    points: int,
    caption: str,
) -> Chart:
    """Measured torque and the torque that models reconstruct (figure 6).

    Args:
        t: (N,) time [s].
        measured: (N, n) [N m, N at prismatic joints]; NaN in all joints is a gap.
        predicted: (N, n) likewise, by the name of each model.
        joints: (n,) names.
        units: (n,) of the torques.
        points: At most so many a line.
        caption: What it shows.
    """
    drawn = [("measured", measured, GREY), *_coloured(predicted)]
    traces = [
        line(
            t, values[:, j], points,
            name=name, legendgroup=name, showlegend=j == 0, yaxis=panel_axis(j),
            line={"color": colour, "width": 1.6 if name == "measured" else 1.0},
            hovertemplate=f"%{{y:.4g}} {unit} at %{{x:.3f}} s",
        )
        for j, unit in enumerate(units)
        for name, values, colour in drawn
    ]  # fmt: skip
    titles = [f"{name} [{unit}]" for name, unit in zip(joints, units, strict=True)]
    axes, height = stacked_panels(titles, "time [s]")
    return Chart(traces, axes, caption, height)


def residual_chart(
    t: Float[ndarray, " samples"],
    residual: Mapping[str, Float[ndarray, "samples joints"]],
    rms: Mapping[str, Float[ndarray, " joints"]],
    joints: Sequence[str],
    units: Sequence[str],
    *,
    band: Float[ndarray, " joints"],
    points: int,
    caption: str,
) -> Chart:
    """What models leave unexplained, with a band to compare it with (figures 5 and 8).

    Args:
        t: (N,) time [s].
        residual: (N, n) measured minus predicted [N m, N at prismatic joints], by the name of each model.
        rms: (n,) root mean square of each residual.
        joints: (n,) names.
        units: (n,) of the torques.
        band: (n,) distance of two lines from zero, such as that rms or the noise floor.
        points: At most so many a line.
        caption: What it shows.
    """
    several = len(residual) > 1
    traces, bands = [], []
    for j, unit in enumerate(units):
        traces += [
            line(
                t, values[:, j], points,
                name=name, legendgroup=name, showlegend=several and j == 0, yaxis=panel_axis(j),
                line={"color": colour, "width": 0.8},
                hovertemplate=f"%{{y:.4g}} {unit} at %{{x:.3f}} s" + ("" if several else "<extra></extra>"),
            )
            for name, values, colour in _coloured(residual)
        ]  # fmt: skip
        bands += [
            {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": panel_axis(j)}
            | {"y0": edge, "y1": edge, "line": BAND_OF_SEVERAL if several else BAND}
            for edge in (-band[j], band[j])
        ]
    titles = [
        f"{name}: rms {' → '.join(f'{value[j]:.3g}' for value in rms.values())} {units[j]}"
        for j, name in enumerate(joints)
    ]
    axes, height = stacked_panels(titles, "time [s]", has_legend=several)
    return Chart(traces, {**axes, "shapes": bands}, caption, height)


def _coloured(models: Mapping[str, ndarray]) -> list[tuple[str, ndarray, str]]:
    """Name, values and colour of each model's line; the last, which is drawn over the others, is blue."""
    colours = (BLUE, VERMILION, GREEN)[: len(models)][::-1]
    return [(name, models[name], colour) for name, colour in zip(models, colours, strict=True)]


def spectrum_chart(
    frequency: Float[ndarray, " frequencies"],
    density: Float[ndarray, "frequencies joints"],
    joints: Sequence[str],
    units: Sequence[str],
    *,
    cutoff: float | None,
    points: int,
    caption: str,
) -> Chart:
    """Spectral density of the residual: flat is noise, a peak or a slope is not.

    Args:
        frequency: (F,) [Hz]; zero is left out.
        density: (F, n) square of the torque's unit over Hz.
        joints: (n,) names.
        units: (n,) of the torques.
        cutoff: Of the low-pass filter, marked where given [Hz].
        points: At most so many a line.
        caption: What it shows.
    """
    positive = frequency > 0
    traces = [
        line(
            frequency[positive], density[positive, j], points,
            name=plain(name), line={"color": COLOURS[j % len(COLOURS)], "width": 1.1},
            hovertemplate=f"%{{y:.3g}} ({units[j]})²/Hz at %{{x:.4g}} Hz",
        )
        for j, name in enumerate(joints)
    ]  # fmt: skip
    shown = density[positive]
    axes: dict[str, object] = {
        "xaxis": {"type": "log", "title": {"text": "frequency [Hz]"}},
        "yaxis": {"type": "log", "title": {"text": _squared(units)}, "exponentformat": "power"},
    }
    if cutoff is not None and shown.size:
        axes["shapes"] = [
            {"type": "line", "x0": cutoff, "x1": cutoff, "yref": "paper", "y0": 0, "y1": 1}
            | {"line": {"color": VERMILION, "dash": "dash"}}
        ]
        axes["annotations"] = [
            {"x": float(np.log10(cutoff)), "y": 1, "yref": "paper", "showarrow": False}
            | {"text": f"cut-off {cutoff:.3g} Hz", "xanchor": "right", "yanchor": "bottom"}
        ]
    rows = -(-len(joints) // 3)  # of the legend
    axes["margin"] = {"l": 8, "r": 8, "t": TOP + 20 * rows, "b": BOTTOM}
    return Chart(traces, axes, caption, SPECTRUM + 20 * rows)


def _squared(units: Sequence[str]) -> str:
    return "density [" + ", ".join(f"({unit})²/Hz" for unit in dict.fromkeys(units)) + "]"
