"""Which rows of a log are measurements of their own."""

from __future__ import annotations

from jaxtyping import Bool
from numpy import ndarray

from oed.experiment.recording import Recording
from oed.experiment.signals.resampling import fresh_rows


def fresh_samples(recording: Recording) -> Bool[ndarray, " samples"]:
    """Rows of a recording that are not stale copies of the row before."""
    fresh = fresh_rows(*(x for x in (recording.q, recording.dq, recording.tau) if x is not None))
    # The last instant anchors the grid's end even where it is stale.
    fresh[-1] = True
    return fresh
