"""Beyond the paper: the closed loop that its gains give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.report.experiment_plots import draw_bode
from paper_figures.reading import columns, settings
from paper_figures.writing import write

CAPTION = (
    "Closed loop from reference to position with observer, sampling and hold, at the least, "
    "typical and greatest inertia of the workspace. At typical inertia the gain crosses -3 dB "
    "at the specified bandwidth (cross); at none does the peak exceed the specification "
    "(dotted)."
)


def draw(results: Path) -> Figure:
    """The figure, once its caption's claim holds.

    Args:
        results: Folder that `studies.paper_experiment` wrote.
    """
    table = columns(results / "figures" / "bode.csv")
    given = settings(results)
    frequency = table["frequency"].astype(float)
    names = ("least", "typical", "greatest")
    gain, phase = (
        [{n: table[f"{kind}_{j}_{n}"].astype(float) for n in names} for j in (1, 2)]
        for kind in ("gain", "phase")
    )
    for joint in gain:
        assert max(values.max() for values in joint.values()) <= given["peak_db"]
        falling = np.interp(np.log(given["bandwidth"]), np.log(frequency), joint["typical"])
        assert abs(falling + 10 * np.log10(2)) < 0.2
    return draw_bode(frequency, gain, phase, bandwidth=given["bandwidth"], peak_db=given["peak_db"])


if __name__ == "__main__":
    write(draw, Path(__file__).stem)
