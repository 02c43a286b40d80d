"""The criterion: what a term beside all else in a model is worth, in nats.

Everything that is chosen is chosen by `worth`: see METHOD.md for its derivation and sources.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.numbers import SMOOTHNESS

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
        occam: What the width of the prior costs [nats].
    """

    nats: float
    coefficients: Float[ndarray, " columns"]
    precision: Float[ndarray, "columns columns"]
    freedom: float
    occam: float


def worth(
    moments: Moments,
    price: float,
    penalty: Float[ndarray, "columns columns"] | None = None,
    *,
    fixed: bool = False,
    chosen: bool = False,
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
        chosen: Whether the penalty is the prior's precision itself, as a fit has it already.
    """
    A, g = moments.information / moments.dilution, moments.score / moments.dilution
    rows = max(moments.rows / moments.dilution, 2.0)
    if fixed:
        own = float(2 * g.sum() - A.sum())
        found = Worth(0.0, np.ones(len(g)), np.zeros_like(A), 0.0, 0.0)
        gained = saturated(own, rows) if own > 0 else own / 2
    elif penalty is None:
        found, gained = _by_unit_information(A, g, rows, moments.dilution)
    else:
        found, gained = _by_smoothness(A, g, rows, moments.dilution, penalty, chosen=chosen)
    if moments.gained is not None:
        gained = moments.gained / moments.dilution
    return dataclasses.replace(found, nats=gained - found.occam - price)


def _by_unit_information(
    A: Float[ndarray, "columns columns"],
    g: Float[ndarray, " columns"],
    rows: float,
    dilution: float,
) -> tuple[Worth, float]:
    """Posterior where P = A / rows, and its gain: all in closed form."""
    size = np.sqrt(np.maximum(np.diag(A), NEW * np.trace(A) + 1e-300))
    values, vectors = np.linalg.eigh(A / np.outer(size, size))
    told = values > NEW * float(values[-1])
    along = vectors[:, told].T @ (g / size)
    shrunk = rows / (rows + 1)
    mean = vectors[:, told] @ (along / values[told]) * shrunk / size
    gained = saturated(float(np.sum(along**2 / values[told])) * shrunk, rows)
    occam = 0.5 * len(g) * float(np.log1p(rows))
    return Worth(0.0, mean, A * (dilution / rows), len(g) * shrunk, occam), gained


def _by_smoothness(
    A: Float[ndarray, "columns columns"],
    g: Float[ndarray, " columns"],
    rows: float,
    dilution: float,
    penalty: Float[ndarray, "columns columns"],
    *,
    chosen: bool,
) -> tuple[Worth, float]:
    """Posterior under the smoothness of largest evidence, or the one that is given.

    The level, which smoothness leaves open, has the information of one row, as a name's
    coefficients have; a difference between neighbours so many times that.
    """
    if chosen:
        options = [penalty]
    else:
        one = float(np.trace(A)) / rows
        options = [one * (s * penalty + np.eye(len(g)) / len(g)) for s in SMOOTHNESS]
    found: list[tuple[float, Worth, float]] = []
    for P in options:
        mean = np.linalg.solve(A + P, g)
        gained = saturated(max(float(g @ mean), 0.0), rows)
        occam = 0.5 * float(np.linalg.slogdet(A + P)[1] - np.linalg.slogdet(P)[1])
        freedom = float(np.trace(np.linalg.solve(A + P, A)))
        own = Worth(0.0, mean, P * dilution, freedom, occam)
        found.append((gained - occam, own, gained))
    _, best, gained = max(found, key=lambda f: f[0])
    return best, gained


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
    values, vectors = np.linalg.eigh(information)
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
