"""What several figures draw of different designs, once the claim that their captions share holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_residuals, draw_torque, draw_trajectories
from paper_figures.reading import mean_rms, settings, torque, trajectory

REPETITIONS = 2  # in the paper's figures 6 and 11


def draw_design(results: Path, design: str) -> Figure:
    """Trajectories that start at zero, keep all limits and are each other's derivatives (2, 7, 9)."""
    t, q, dq, ddq = trajectory(results, design)
    given = settings(results)
    limits = [np.array(given[f"{kind}_limit"]) for kind in ("position", "velocity", "acceleration")]
    for values, limit in zip((q, dq, ddq), limits, strict=True):
        assert (np.abs(values) <= limit * (1 + 1e-6)).all(), "a limit is left"
    assert np.ptp(q, axis=0).min() > 0, "a joint does not move"
    assert np.abs(q[0]).max() < 1e-6, "sums of sines start at zero"
    for values, slope in ((q, dq), (dq, ddq)):
        found = np.gradient(values, t, axis=0, edge_order=2)
        # Central differences of 50 points a second miss less than a hundredth.
        assert np.abs(found - slope).max() < 0.01 * np.abs(slope).max(), "no derivative"
    return draw_trajectories(t, q, dq, ddq, limits)


def draw_residual(results: Path, design: str, part: str) -> Figure:
    """Residuals whose rms is about the table's, and below half of the torque's (5, 8, 10)."""
    t, measured, predicted = torque(results, design, part)
    residual = measured - predicted
    found = np.sqrt((residual**2).mean(axis=0))
    np.testing.assert_allclose(found, mean_rms(results, design, part), rtol=0.2)
    assert (found < 0.5 * np.sqrt((measured**2).mean(axis=0))).all(), "half is left"
    given = settings(results)
    breaks = [float(given["horizon"]) * k for k in range(1, int(given["repetitions"]))]
    return draw_residuals(t, residual, breaks)


def draw_reconstruction(results: Path, design: str) -> Figure:
    """Torque of two repetitions, reconstructed: correlation above 0.8, slope near one (6, 11)."""
    samples = int(settings(results)["samples"]) * REPETITIONS
    t, measured, predicted = (x[:samples] for x in torque(results, design, "estimation"))
    for j in range(measured.shape[1]):
        assert np.corrcoef(measured[:, j], predicted[:, j])[0, 1] > 0.8
        # Regression of the measured on the predicted: least squares makes it one, sign and all.
        slope = (measured[:, j] @ predicted[:, j]) / (predicted[:, j] @ predicted[:, j])
        assert abs(slope - 1) < 0.15, slope
    return draw_torque(t, measured, predicted)
