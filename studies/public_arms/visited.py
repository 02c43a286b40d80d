"""Where sealed recordings go that the fitted ones did not: positions, speeds and loads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.preparation.prepared import Prepared

# Of the fitted range, at each end: what a trajectory's own ripple overshoots.
MARGIN = 0.02
LEAST_SHARE = 0.01  # of the rows, from which it is said


def beyond(
    fitted: Sequence[Float[ndarray, "_ joints"]], sealed: Sequence[Float[ndarray, "_ joints"]]
) -> Float[ndarray, " joints"]:
    """(n,) share of sealed rows outside the range of the fitted ones."""
    seen, asked = np.concatenate(list(fitted)), np.concatenate(list(sealed))
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = MARGIN * (high - low)
    return np.mean((asked < low - margin) | (asked > high + margin), axis=0)


def range_note(prepared: Sequence[Prepared]) -> str:
    """What the sealed rows visit beyond the fitted, in words; "same range" if nothing."""
    groups = {role: [p for p in prepared if p.role == role] for role in ("estimation", "test")}
    signals = {
        "position": lambda p: p.motion.q,
        "speed": lambda p: p.motion.dq,
        "acceleration": lambda p: p.motion.ddq,
        "load": lambda p: p.torque,
    }
    said = []
    for name, signal in signals.items():
        share = beyond(*([signal(p) for p in group] for group in groups.values()))
        over = [f"{share[j]:.0%} of joint {j + 1}" for j in np.flatnonzero(share > LEAST_SHARE)]
        if over:
            said.append(f"{name}: {', '.join(over)}")
    return "; ".join(said) or "same range"
