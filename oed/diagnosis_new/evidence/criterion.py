"""The criterion: what a term beside all else in a model is worth, in nats.

Everything that is chosen is chosen by `worth`: see METHOD.md for its derivation and sources.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import cho_factor, cho_solve, eigh

from oed.diagnosis_new.numbers import NULL_SHARE, SMOOTHNESS

NEW = 1e-9  # share of a column outside the span of all else, below which rounding is what is new


@dataclass(frozen=True)
class Moments:
    """What rows tell of a term's coefficients beside all else in the model.

    Attributes:
        information: (k, k) A = X' V^-1 X of the columns beside all else.
        score: (k,) g = X' V^-1 r, r what is left without the term.
        rows: That count.
        dilution: tau, rows that tell as much as one (see `score_dilution`).
        gained: Rise of the log score by the term, all refitted [nats of independent rows]; None for
            that of the linear fit, g' (A + P)^-1 g.
    """

    information: Float[ndarray, "columns columns"]
    score: Float[ndarray, " columns"]
    rows: float
    dilution: float = 1.0
    gained: float | None = None


@dataclass(frozen=True)
class Worth:
    """Log evidence of a term.

    Attributes:
        nats: log p(rows | with) - log p(rows | without), its price paid.
        coefficients: (k,) posterior mean.
        precision: (k, k) of the prior, in the units of `information`.
        freedom: Effective degrees of freedom.
    """

    nats: float
    coefficients: Float[ndarray, " columns"]
    precision: Float[ndarray, "columns columns"]
    freedom: float


def worth(
    moments: Moments,
    price: float,
    penalty: Float[ndarray, "columns columns"] | None = None,
    *,
    fixed: bool = False,
) -> Worth:
    """Log evidence of a term beside all else in its model: the one criterion.

    log integral N(r | X beta, tau V) N(beta | 0, P^-1) d beta - log N(r | 0, tau V) - price,

    where P is the information of one row for a term with a formula (Kass and Wasserman 1995), or
    a smoothing prior whose precision has the largest evidence (MacKay 1992), and the quadratic
    form is that of a Student t over independent blocks, since the variance is estimated too.

    Args:
        moments: What rows tell of it.
        price: -log of the prior probability of its place, name and shapes.
        penalty: Of a smoothing prior; None for unit information.
        fixed: Whether the coefficients are 1 by construction: a prior of no width.
    """
    if fixed:
        gained = moments.gained
        if gained is None:
            own = float(2 * moments.score.sum() - moments.information.sum())
            gained = saturated(own, moments.rows) if own > 0 else own / 2
        ones = np.ones(len(moments.score))
        return Worth(
            gained / moments.dilution - price, ones, np.zeros_like(moments.information), 0.0
        )
    A, g = moments.information / moments.dilution, moments.score / moments.dilution
    rows = max(moments.rows / moments.dilution, 2.0)
    size = np.sqrt(np.maximum(np.diag(A), NEW * np.trace(A) + 1e-300))
    values, vectors = eigh(A / np.outer(size, size))
    told = values > NEW * float(values.max())
    A = (vectors * np.maximum(values, NEW * values.max())) @ vectors.T
    g = vectors[:, told] @ (vectors[:, told].T @ (g / size))
    if penalty is None:
        options = [A / rows]
    else:
        scaled = penalty / np.outer(size, size)
        scaled *= len(g) / max(np.trace(scaled), 1e-300)
        flat = NULL_SHARE * np.eye(len(g))
        options = [s * scaled + flat / rows for s in SMOOTHNESS]
    best: tuple[float, ndarray, ndarray] | None = None
    for P in options:
        factor = cho_factor(A + P, lower=True)
        mean = cho_solve(factor, g)
        gained = saturated(float(g @ mean), rows)
        if moments.gained is not None:
            gained = moments.gained / moments.dilution
        occam = 2 * np.log(np.diag(factor[0])).sum() - np.linalg.slogdet(P)[1]
        nats = gained - 0.5 * float(occam) - price
        if best is None or nats > best[0]:
            best = nats, mean, P
    if best is None:
        raise ValueError("a prior needs at least one precision")
    nats, mean, P = best
    freedom = float(np.trace(np.linalg.solve(A + P, A)))
    unit = np.outer(size, size) * moments.dilution
    return Worth(nats, mean / size, P * unit, freedom)


def saturated(quadratic: float, rows: float) -> float:
    """Log likelihood ratio of a quadratic form where the variance falls with what is explained."""
    return 0.5 * rows * float(np.log1p(quadratic / rows))


def score_dilution(
    scores: Float[ndarray, "blocks columns"],
    leverage: float,
    information: Float[ndarray, "columns columns"],
) -> float:
    """Ratio of the scores' variance between blocks to what independent rows would have (tau).

    The trace of the sandwich over the bread (White 1980; Cameron and Miller 2015), at least 1.

    Args:
        scores: X_b' V^-1 r_b of each block, r what the whole model leaves.
        leverage: Share of the blocks' own scores that the fit has taken, in degrees of freedom.
        information: A.
    """
    values, vectors = eigh(information)
    kept = values > NEW * max(float(values.max(initial=0.0)), 1e-300)
    white = scores @ (vectors[:, kept] / np.sqrt(values[kept]))
    freedom = int(kept.sum()) - leverage
    return max(1.0, float(np.sum(white**2)) / max(freedom, 0.25 * max(int(kept.sum()), 1)))


def log_score(
    squares: Float[ndarray, " joints"],
    rows: Float[ndarray, " joints"],
    tolerated: Float[ndarray, " joints"],
) -> float:
    """Log score of rows, each joint's variance the larger of its own and what is tolerated.

    Args:
        squares: (n,) sums of squares of white errors.
        rows: (n,) rows that count.
        tolerated: (n,) variance without blame, phi, in units of noise.
    """
    s = squares / np.maximum(rows, 1.0)
    variance = np.maximum(tolerated, s)
    return float(-0.5 * np.sum(rows * (np.log(variance) + s / variance)))
