"""What several figures draw of different designs, once the claim that their captions share holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_residuals, draw_torque, draw_trajectories
from paper_figures.reading import reproduced, settings, torque, trajectory


def draw_design(results: Path, design: str) -> Figure:
    """Trajectories that move every joint and keep all limits (figures 2, 7, 9)."""
    t, q, dq, ddq = trajectory(results, design)
    given = settings(results)
    limits = [np.array(given[f"{kind}_limit"]) for kind in ("position", "velocity", "acceleration")]
    for values, limit in zip((q, dq, ddq), limits, strict=True):
        assert (np.abs(values) <= limit * (1 + 1e-6)).all(), "a limit is left"
    assert np.ptp(q, axis=0).min() > 0, "a joint does not move"
    return draw_trajectories(t, q, dq, ddq, limits)


def draw_residual(results: Path, design: str, part: str) -> Figure:
    """Residuals whose rms is the table's, and below half of the torque's (figures 5, 8, 10)."""
    t, measured, predicted = torque(results, design, part)
    residual = measured - predicted
    rms = np.sqrt((residual**2).mean(axis=0))
    for j, value in enumerate(rms):
        stated = reproduced(results, design, f"rms, {part} set, joint {j + 1}")
        assert abs(value - stated) < 1e-3 * stated, "the table states another rms"
        assert value < 0.5 * np.sqrt((measured[:, j] ** 2).mean())
    given = settings(results)
    breaks = [float(given["horizon"]) * k for k in range(1, int(given["repetitions"]))]
    return draw_residuals(t, residual, breaks)


def draw_reconstruction(results: Path, design: str) -> Figure:
    """Torque of the first repetition, reconstructed with a correlation above 0.8 (figures 6, 11)."""
    signals = torque(results, design, "estimation")
    t, measured, predicted = (x[: int(settings(results)["samples"])] for x in signals)
    for j in range(measured.shape[1]):
        assert np.corrcoef(measured[:, j], predicted[:, j])[0, 1] > 0.8
    return draw_torque(t, measured, predicted)
