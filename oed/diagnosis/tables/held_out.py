"""Whether an addition pays on rows that it was not fitted to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis_new.rows.weighted_rows import Rows

SEGMENTS_PER_FOLD = 4


@dataclass(frozen=True)
class CrossValidation:
    """Squared prediction errors of segments that were left out in turn.

    Attributes:
        squares: (segments,) white prediction errors.
    """

    squares: Float[ndarray, " segments"]

    def gain_over(self, before: CrossValidation) -> tuple[float, float]:
        """Fall of the squares against another model, and what is left without the best segment.

        An effect may live in few segments, where the load is high or the joint turns; but what
        lives in one alone may be an accident.
        """
        gains = before.squares - self.squares
        return float(gains.sum()), float(gains.sum() - gains.max())


def _segments_of(rows: Rows, folds: int) -> Int[ndarray, " rows"]:
    """(R,) segment of each row: stretches of the motion's phase, the same in every repetition."""
    count = folds * SEGMENTS_PER_FOLD
    parts, offset = [], 0
    for p in rows.prepared:
        phase = p.phase
        span = max(float(phase.max() - phase.min()), 1e-9)
        own = np.minimum((count * (phase - phase.min()) / span).astype(int), count - 1)
        parts.append(own + offset)
        offset += count
    return np.concatenate(parts)


def cross_validate(found: Augmented, folds: int) -> CrossValidation:
    """Leave a fold of segments out, fit the rest, predict it; shapes stay.

    Every `folds`-th segment of each recording belongs to one fold.
    """
    fit = found.fit
    segments = _segments_of(fit.rows, folds)
    basis = fit.projection.basis
    # In the span's own coordinates the whole fit has unit Gram matrix, and the residual is
    # all that a left-out part can change: y = basis c + residual for any c.
    residual = fit.residual
    squares = np.zeros(int(segments.max()) + 1)
    for fold in range(folds):
        held = segments % folds == fold
        part = basis[:, held]
        gram = np.einsum("jrb,jrc->bc", part, part, optimize=True)
        moment = np.einsum("jrb,jr->b", part, residual[:, held], optimize=True)
        values, vectors = np.linalg.eigh(gram)
        # A direction that only the held-out part excites cannot be predicted without it.
        kept = values < 1 - 1e-6
        shift = vectors[:, kept] @ (vectors[:, kept].T @ moment / (1 - values[kept]))
        error = np.sum((residual[:, held] + part @ shift) ** 2, axis=0)
        np.add.at(squares, segments[held], error)
    return CrossValidation(squares)
