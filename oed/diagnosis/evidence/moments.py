"""What rows tell of one term of a fitted model, counted by what the whole model leaves."""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Bool
from numpy import ndarray

from oed.diagnosis.evidence.columns import white_effect
from oed.diagnosis.evidence.criterion import Moments, score_dilution
from oed.diagnosis.evidence.fit import Projection
from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.evidence.term import Term
from oed.experiment.signals.correlation_length import correlation_length


def correlated_rows(whole: Fitted, joint: int, where: Bool[ndarray, " rows"]) -> float:
    """Rows over which what a model leaves of a joint is correlated."""
    left = whole.projection.residual[joint, where]
    return correlation_length([left - left.mean()])


def moments_of(
    whole: Fitted,
    rest: Projection,
    columns: dict[int, ndarray],
    used: Bool[ndarray, " rows"],
    *,
    gained: float | None = None,
    tau: float | None = None,
) -> Moments:
    """What rows tell of columns beside `rest`, each block's score by what `whole` leaves.

    Args:
        whole: The model that is judged.
        rest: The fit beside which the columns stand.
        columns: joint -> (R, k) white columns of the term.
        used: Rows that are looked at.
        gained: As in `Moments`.
        tau: Dilution if it is known.
    """
    problem = whole.problem
    counted = np.maximum(problem.rows.counts[:, used].sum(axis=1), 1.0)
    if not columns:  # a gear that no longer gives way, say, tells as little as it explains
        return Moments(np.zeros((1, 1)), np.zeros(1), float(counted.sum()), 1.0, gained)
    own = rest.beside(columns)
    A, g, inside = own.information, own.score, own.within
    rows = float(sum(counted[j] for j in columns))
    if tau is not None:
        return Moments(A, g, rows, tau, gained)
    main = max(columns, key=lambda j: float(np.sum(columns[j] ** 2)))
    blocks = problem.rows.blocks(correlated_rows(whole, main, used))[used]
    order = np.argsort(blocks, kind="stable")
    ends = np.cumsum(np.bincount(blocks))
    values, vectors = np.linalg.eigh(A)
    kept = values > 1e-9 * max(float(values.max(initial=0.0)), 1e-300)
    white = vectors[:, kept] / np.sqrt(values[kept])
    scores = np.zeros((len(ends), len(g)))
    squares = np.zeros((len(ends), white.shape[1], white.shape[1]))
    for j in range(problem.rows.joints):
        X = -rest.basis[j] @ inside
        if j in columns:
            X = X + columns[j][used] * rest.weights[j]
        left = whole.projection.residual[j, used] * rest.weights[j]
        Z = X @ white
        for block, own in enumerate(np.split(order, ends[:-1])):
            scores[block] += left[own] @ X[own]
            squares[block] += Z[own].T @ Z[own]
    return Moments(A, g, rows, score_dilution(scores, float(np.sum(squares**2)), A), gained)


def columns_of(term: Term, whole: Fitted, place: slice) -> dict[int, ndarray]:
    """White columns of a term of a model; of one that is installed, the change that it makes."""
    if not term.steps:
        own = whole.projection.columns[:, :, place]
        return {j: own[j] for j in range(len(own)) if np.any(own[j])}
    bare = dataclasses.replace(whole.context, model=whole.problem.base)
    effect = term.candidate.effect(bare, term.values)
    return white_effect(effect, bare.model, whole.problem.rows)
