"""How a weighed load compares with the true one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.estimation.load.payload import Payload
from oed.estimation.load.quantities import central_inertia


def judged(found: Payload, body: np.ndarray) -> dict[str, str | float]:
    """Which intervals hold the truth, how far off the estimate is, and how wide they are.

    Args:
        found: The estimate.
        body: The truth about the frame.
    """
    truth = _truth(body)
    error = np.array([q.value for q in found.quantities]) - truth
    half = [
        np.nan if q.interval is None else (q.interval[1] - q.interval[0]) / 2
        for q in found.quantities
    ]
    return {
        "mass": body[0],
        "held": held(found, body),
        "mass_error": error[0] / body[0],
        "mass_half": half[0] / body[0],
        "centre_error": float(np.linalg.norm(error[1:4])),
        "centre_half": _largest(half[1:4]),
        "inertia_half": _largest(half[4:]),
        "margin": found.margin,
    }


def _largest(half: Sequence[float]) -> float:
    return float(np.max(half)) if np.isfinite(half).all() else float("nan")


def held(found: Payload, body: np.ndarray) -> str:
    """One letter a quantity: 1 held, 0 not held, - no interval claimed."""
    letters = []
    for quantity, true in zip(found.quantities, _truth(body), strict=True):
        if quantity.interval is None:
            letters.append("-")
        else:
            low, high = quantity.interval
            letters.append("1" if low <= true <= high else "0")
    # A first letter that no table takes for a number.
    return "h" + "".join(letters)


def _truth(body: np.ndarray) -> np.ndarray:
    inertia = central_inertia(body)[np.triu_indices(3)]
    return np.concatenate([body[:1], body[1:4] / body[0], inertia])
