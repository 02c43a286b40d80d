"""Charts of an arm whose joints have awkward names."""

import numpy as np

from oed.report.chart import Chart
from oed.report.estimation_charts import residual_chart, spectrum_chart, torque_chart
from oed.report.parameter_charts import convergence_chart, interval_charts

JOINTS = ("shoulder <b>", "$elbow_{", "slide")
UNITS = ("N m", "N m", "N")


def charts(samples: int = 40_000) -> list[Chart]:
    """One of each kind; the recording has a gap."""
    rng = np.random.default_rng(3)
    t = np.arange(samples) * 1e-3
    measured = np.sin(t[:, None] * np.arange(1, 4))
    residual = 0.1 * rng.normal(size=measured.shape)
    residual[samples // 2] = np.nan
    rms = np.full(3, 0.1)
    frequency = np.linspace(0, 500, 301)
    names = [f"m_{k} + 0.25 Ixx_{k} - 1.5 mz_{k}" for k in range(6)]
    values = rng.normal(size=6)
    spread = np.stack([values - 0.5, values + 0.5], axis=1)
    steps = np.arange(10, 400)
    settling = values + rng.normal(size=(steps.size, 6)) / steps[:, None]
    given = {"points": 2000, "caption": "What <it> shows."}
    return [
        torque_chart(t, measured, {"predicted": measured - residual}, JOINTS, UNITS, **given),
        residual_chart(
            t, {"predicted": residual}, {"predicted": rms}, JOINTS, UNITS, band=rms, **given
        ),
        residual_chart(
            t,
            {"before": 2 * residual, "after": residual},
            {"before": 2 * rms, "after": rms},
            JOINTS,
            UNITS,
            band=rms,
            **given,
        ),
        spectrum_chart(frequency, np.ones((301, 3)), JOINTS, UNITS, cutoff=30.0, **given),
        *interval_charts(names, values, spread, ["kg"] * 3 + ["kg m^2"] * 3, caption="All."),
        convergence_chart(
            steps, settling, np.ones_like(settling), names, ["kg"] * 6, caption="Settles."
        ),
    ]
