"""Whether the declared gravity has the size that it has everywhere on Earth.

Whether the arm feels it is weighed among all other causes (`repair`).
"""

from __future__ import annotations

import numpy as np

from oed.checkup.finding import Finding
from oed.checkup.suspicion import STANDARD_GRAVITY, is_on_earth
from oed.experiment.dataset import DataSet


def gravity_finding(dataset: DataSet) -> Finding:
    """The size of the gravity that is declared."""
    size = float(np.linalg.norm(dataset.robot.gravity))
    if size == 0:
        return Finding("gravity", "green", "gravity is declared to be zero")
    if is_on_earth(dataset.robot.gravity):
        return Finding("gravity", "green", "the declared gravity has the size that it has on Earth")
    ratio = size / STANDARD_GRAVITY
    text = f"the declared gravity of {size:.4g} m/s^2 is {ratio:.3g} times that on Earth"
    return Finding("gravity", "amber", text, "declare it in m/s^2")
