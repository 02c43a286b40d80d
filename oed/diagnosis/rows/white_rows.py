"""White rows of all recordings that a search may look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.diagnosis.numbers import BLOCK_SECONDS, HELD_OUT_SHARE, MOST_BLOCK_SHARE
from oed.estimation.noise_floor.weighted_rows import Rows
from oed.experiment.paths import steps_apart
from oed.experiment.preparation.prepared import Prepared


@dataclass(frozen=True, eq=False)
class WhiteRows:
    """Rows of estimation and validation recordings in units of noise; no test recording gets here.

    Attributes:
        rows: Filter, noise and weights of the recordings, one after another.
        torque: (n, R) white torque.
        fitted: (R,) rows that a fit on the estimation recordings uses.
        held_out: (R,) rows that only score.
        phase: (R,) index of a row within its period, or within its recording; rows of several
            repetitions at one phase share it.
        counts: (n, R) weight of each row, 0 to 1.
    """

    rows: Rows
    torque: Float[ndarray, "joints rows"]
    fitted: Bool[ndarray, " rows"]
    held_out: Bool[ndarray, " rows"]
    phase: Int[ndarray, " rows"]
    counts: Float[ndarray, "joints rows"]

    @classmethod
    def of(cls, rows: Rows) -> WhiteRows:
        """Lay out recordings whose noise and weights are known."""
        prepared = rows.prepared
        held = np.concatenate([np.full(p.rows, p.role == "validation") for p in prepared])
        if not held.any():
            held = np.concatenate(
                [np.arange(p.rows) >= (1 - HELD_OUT_SHARE) * p.rows for p in prepared]
            )
        phases, start = [], 0
        for p in prepared:
            rate = p.band.analysis_rate
            own = np.round((p.phase - p.phase.min()) * rate).astype(int)
            phases.append(start + own)
            start += int(own.max()) + 1
        return cls(rows, rows.torque(), ~held, held, np.concatenate(phases), rows.weights.T**2)

    @property
    def prepared(self) -> Sequence[Prepared]:
        """The recordings."""
        return self.rows.prepared

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.torque)

    @cached_property
    def counted(self) -> Float[ndarray, " joints"]:
        """(n,) rows that count."""
        return np.maximum(self.counts.sum(axis=1), 1.0)

    @cached_property
    def off_path(self) -> Bool[ndarray, " rows"]:
        """(R,) held-out rows of a motion along no fitted path; of an arm that stands, none."""
        positions = [p.motion.q[p.samples] for p in self.prepared]
        ends = np.cumsum([p.rows for p in self.prepared])[:-1]
        seen = [q[own] for q, own in zip(positions, np.split(self.fitted, ends), strict=True)]
        fitted = [q for q in seen if len(q)]
        rate = self.prepared[0].band.analysis_rate
        apart = [steps_apart(q, fitted, rate) for q in positions]
        return self.held_out & (np.concatenate(apart) > 1)

    def blocks(self, correlated: float) -> Int[ndarray, " rows"]:
        """Number of the block of each row: stretches of phase that misfit makes dependent.

        Args:
            correlated: Rows over which what is left is correlated.
        """
        phases = int(self.phase.max()) + 1
        least = BLOCK_SECONDS * self.prepared[0].band.analysis_rate
        length = int(np.clip(2 * correlated, least, max(least, phases * MOST_BLOCK_SHARE)))
        return self.phase // max(length, 1)

    def whiten(
        self, columns: Sequence[Float[ndarray, "_ columns"]], joint: int
    ) -> Float[ndarray, "rows columns"]:
        """White rows of one joint from fine columns, one array a recording."""
        return self.rows.whiten_fine(columns, joint)
