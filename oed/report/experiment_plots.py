"""Figures of a planned experiment: trajectories, search, recursion, torque, loop gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from oed.report.style import (
    BLACK,
    BLUE,
    COLUMN,
    GREEN,
    GREY,
    ORANGE,
    PAGE,
    STYLE,
    VERMILION,
    new_figure,
)

JOINT_COLOURS = (BLUE, VERMILION, GREEN, ORANGE)
JOINT_STYLES = ("-", "--", "-.", ":")
MARKERS = 40  # on a curve that has more points: as many as can be told apart in a column
LEGEND = {"fontsize": 7.0, "frameon": False}


@mpl.rc_context(STYLE)
def draw_trajectories(
    t: Float[ndarray, " samples"],
    position: Float[ndarray, "samples joints"],
    velocity: Float[ndarray, "samples joints"],
    acceleration: Float[ndarray, "samples joints"],
    limits: Sequence[Float[ndarray, " joints"]],
) -> Figure:
    """Position, velocity and acceleration of all joints, with what may not be left in grey.

    Args:
        t: Time [s].
        position: [rad].
        velocity: [rad/s].
        acceleration: [rad/s^2].
        limits: Largest absolute position, velocity and acceleration.
    """
    figure = new_figure(COLUMN, 3.6)
    panels = figure.subplots(3, 1, sharex=True)
    kinds = (
        ("position\n[rad]", position),
        ("velocity\n[rad/s]", velocity),
        ("acceleration\n[rad/s²]", acceleration),
    )
    for panel, (label, values), limit in zip(panels, kinds, limits, strict=True):
        for j in range(values.shape[1]):
            panel.plot(
                t,
                values[:, j],
                color=JOINT_COLOURS[j],
                linestyle=JOINT_STYLES[j],
                label=f"joint {j + 1}",
            )
        largest = 1.15 * np.abs(values).max()
        for side in (-1, 1):
            # A limit far beyond the motion would only flatten the curves.
            if limit.min() < 1.6 * largest:
                panel.axhline(side * limit.min(), color=GREY, linewidth=0.8, linestyle=":")
        panel.set_ylabel(label)
        panel.margins(x=0)
    panels[-1].set_xlabel("time [s]")
    figure.align_ylabels(panels)
    _legend_above(figure, panels[0])
    return figure


@mpl.rc_context(STYLE)
def draw_generations(
    generation: Float[ndarray, " generations"],
    best: Mapping[str, Float[ndarray, " generations"]],
    mean: Mapping[str, Float[ndarray, " generations"]],
    *,
    published: Mapping[str, float],
) -> Figure:
    """Best and mean fitness by generation, one panel a criterion, beside a published value.

    A criterion named J_k is drawn on a logarithmic ordinate.
    """
    figure = new_figure(COLUMN, 3.2)
    panels = figure.subplots(len(best), 1, sharex=True)
    every = 1 + len(generation) // MARKERS
    for panel, name in zip(np.atleast_1d(panels), best, strict=True):
        panel.plot(
            generation,
            best[name],
            color=BLUE,
            marker="o",
            markersize=2.2,
            markevery=every,
            label="best",
        )
        panel.plot(
            generation,
            mean[name],
            color=VERMILION,
            linestyle="--",
            marker="s",
            markersize=2.0,
            markevery=every,
            label="mean",
        )
        panel.axhline(published[name], color=BLACK, linewidth=0.8, linestyle=":", label="paper")
        symbol = name.replace("J_k", "$J_k$ = cond Λ").replace("J_d", "$J_d$ = log₁₀ det Λ")
        panel.set_ylabel(symbol)
        if name == "J_k":
            panel.set_yscale("log")
        panel.margins(x=0.02)
    np.atleast_1d(panels)[-1].set_xlabel("generation")
    figure.align_ylabels(panels)
    _legend_above(figure, np.atleast_1d(panels)[0])
    return figure


@mpl.rc_context(STYLE)
def draw_recursion(
    samples: Float[ndarray, " steps"],
    estimates: Float[ndarray, "steps parameters"],
    std: Float[ndarray, "steps parameters"],
    truth: Float[ndarray, " parameters"],
    labels: Sequence[str],
) -> Figure:
    """Recursive estimates with twice their deviation, and the truth."""
    figure = new_figure(PAGE, 3.9)
    panels = figure.subplots(2, (len(labels) + 1) // 2, sharex=True)
    for p, (panel, label) in enumerate(zip(panels.T.ravel(), labels, strict=True)):
        lower, upper = estimates[:, p] - 2 * std[:, p], estimates[:, p] + 2 * std[:, p]
        panel.fill_between(samples, lower, upper, color=BLUE, alpha=0.2, linewidth=0)
        panel.plot(samples, estimates[:, p], color=BLUE, label="estimate ± 2σ")
        panel.axhline(truth[p], color=BLACK, linewidth=0.9, linestyle="--", label="truth")
        panel.set_title(label)
        # The first few estimates are wild; the ordinate is for those that follow.
        settled = slice(len(samples) // 12, None)
        low = min(np.nanmin(lower[settled]), truth[p])
        high = max(np.nanmax(upper[settled]), truth[p])
        panel.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
        panel.set_xlim(0, samples[-1])
    for panel in panels[-1]:
        panel.set_xlabel("sample")
    _legend_above(figure, panels[0, 0])
    return figure


@mpl.rc_context(STYLE)
def draw_torque(
    t: Float[ndarray, " samples"],
    measured: Float[ndarray, "samples joints"],
    predicted: Float[ndarray, "samples joints"],
) -> Figure:
    """Measured and reconstructed torque of every joint."""
    figure, panels = _stacked(measured.shape[1], 2.9)
    for j, panel in enumerate(panels):
        panel.plot(t, measured[:, j], color=GREY, linewidth=1.6, label="measured torque")
        panel.plot(t, predicted[:, j], color=VERMILION, linewidth=0.9, label="reconstructed")
        panel.set_ylabel(f"joint {j + 1}\n[N m]")
        panel.margins(x=0)
    panels[-1].set_xlabel("time [s]")
    _legend_above(figure, panels[0])
    return figure


@mpl.rc_context(STYLE)
def draw_residuals(
    t: Float[ndarray, " samples"],
    residual: Float[ndarray, "samples joints"],
    breaks: Sequence[float],
) -> Figure:
    """Torque residual of every joint, its rms as a band, repetitions told apart."""
    figure, panels = _stacked(residual.shape[1], 2.7)
    for j, panel in enumerate(panels):
        rms = float(np.sqrt(np.mean(residual[:, j] ** 2)))
        panel.axhspan(-rms, rms, color=ORANGE, alpha=0.25, linewidth=0, label="± rms")
        panel.plot(t, residual[:, j], color=BLUE, linewidth=0.6, label="torque residual")
        for instant in breaks:
            panel.axvline(instant, color=GREY, linewidth=0.6, linestyle=":")
        panel.set_ylabel(f"joint {j + 1}\n[N m]")
        panel.margins(x=0)
        panel.grid(visible=False, axis="x")
    panels[-1].set_xlabel("time in motion [s]")
    _legend_above(figure, panels[0])
    return figure


@mpl.rc_context(STYLE)
def draw_bode(
    frequency: Float[ndarray, " points"],
    gain: Sequence[Mapping[str, Float[ndarray, " points"]]],
    phase: Sequence[Mapping[str, Float[ndarray, " points"]]],
    *,
    bandwidth: float,
    peak_db: float,
) -> Figure:
    """Closed-loop gain and phase of every joint, by inertia, with the specification.

    Args:
        frequency: [rad/s].
        gain: By joint, then by name of the inertia [dB].
        phase: Likewise [degrees].
        bandwidth: Specified [rad/s].
        peak_db: Greatest peak allowed [dB].
    """
    figure = new_figure(PAGE, 3.4)
    panels = figure.subplots(2, len(gain), sharex=True, sharey="row")
    for j, (gains, phases) in enumerate(zip(gain, phase, strict=True)):
        for k, name in enumerate(gains):
            style = {
                "color": JOINT_COLOURS[k],
                "linestyle": JOINT_STYLES[k],
                "label": f"{name} inertia",
            }
            panels[0, j].semilogx(frequency, gains[name], **style)
            panels[1, j].semilogx(frequency, phases[name], **style)
        panels[0, j].axhline(peak_db, color=BLACK, linewidth=0.7, linestyle=":")
        panels[0, j].plot([bandwidth], [-10 * np.log10(2)], "k+", markersize=7)
        panels[0, j].set_title(f"joint {j + 1}")
        panels[0, j].set_ylim(-25, 8)
        panels[1, j].set_xlabel("frequency [rad/s]")
    panels[0, 0].set_ylabel("gain [dB]")
    panels[1, 0].set_ylabel("phase [°]")
    figure.align_ylabels(panels[:, 0])
    _legend_above(figure, panels[0, 0])
    return figure


def _stacked(joints: int, height: float) -> tuple[Figure, Sequence[Axes]]:
    figure = new_figure(COLUMN, height)
    panels = np.atleast_1d(figure.subplots(joints, 1, sharex=True))
    return figure, list(panels)


def _legend_above(figure: Figure, panel: Axes) -> None:
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), **LEGEND)
