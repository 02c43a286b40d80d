"""What an addition is worth on recordings that it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial


def validation_gain(
    shop: Workshop, standing: Sequence[Trial], trial: Trial, *, as_it_is: bool = False
) -> float | None:
    """Share by which one of some additions lowers the held-out error of its joints.

    The error is each joint's root mean square over its own without the addition; None without
    validation recordings.

    Args:
        shop: The laid-out data.
        standing: All additions.
        trial: One of them.
        as_it_is: Whether base parameters do not give way, uncertain as they may be.
    """
    others = [t for t in standing if t.key != trial.key]
    old, new = shop.foretold(others, standing, as_it_is=as_it_is)
    if new is None or old is None:
        return None
    joints = list(trial.group)
    return float(1 - np.sqrt(np.mean((new[joints] / old[joints]) ** 2)))
