"""Information of a motion and the optimality criteria: condition number, D, A and E.

Lambda = H^T R_v^-1 H + prior (Calafiore 2001, section 2). J_k = cond Lambda, to be made small,
and J_d = log10 det Lambda, to be made large: the paper's logarithm is to the base 10. J_d grows
with the number of rows, so a value says nothing without its instants and rows.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import scipy.linalg
from jaxtyping import Float
from numpy import ndarray

Criterion = Literal["J_k", "J_d", "A", "E"]
CRITERIA: tuple[Criterion, ...] = get_args(Criterion)
# Eigenvalues below this fraction of the largest are rounding of the product H^T H.
RANK_TOLERANCE = 1e-15


def information(
    columns: Float[ndarray, "samples joints columns"],
    covariance: Float[ndarray, "..."] | None = None,
    prior: Float[ndarray, "columns columns"] | None = None,
) -> Float[ndarray, "columns columns"]:
    """Lambda of stacked regressor rows.

    Args:
        columns: Torque per unit of each parameter at every instant and joint.
        covariance: R_v of the measured torque [N^2 m^2]: (n,) variances of the joints, (n, n)
            for joints that are correlated at an instant, or (N n, N n) of all rows, sample by
            sample; the identity if None.
        prior: Information already at hand, such as that of earlier experiments.

    Raises:
        ValueError: If the shape of `covariance` fits none of these.
    """
    samples, joints, count = columns.shape
    rows = samples * joints
    if covariance is None:
        white = columns.reshape(rows, count)
    elif covariance.shape == (joints,):
        white = (columns / np.sqrt(covariance)[:, None]).reshape(rows, count)
    elif covariance.shape == (joints, joints):
        white = (whitening(covariance) @ columns).reshape(rows, count)
    elif covariance.shape == (rows, rows):
        factor = np.linalg.cholesky(covariance)
        white = scipy.linalg.solve_triangular(factor, columns.reshape(rows, count), lower=True)
    else:
        raise ValueError(
            f"covariance {covariance.shape} of {samples} instants and {joints} joints: expected "
            f"({joints},), ({joints}, {joints}) or ({rows}, {rows})"
        )
    result = white.T @ white
    return result if prior is None else result + prior


def whitening(covariance: Float[ndarray, "joints joints"]) -> Float[ndarray, "joints joints"]:
    """L^-1 with R_v = L L^T: rows multiplied by it have unit covariance."""
    factor = np.linalg.cholesky(covariance)
    return scipy.linalg.solve_triangular(factor, np.eye(len(factor)), lower=True)


def condition(information: Float[ndarray, "columns columns"]) -> float:
    """J_k = cond Lambda, infinite where Lambda is singular to rounding."""
    eigenvalues = np.linalg.eigvalsh(information)
    is_singular = eigenvalues[0] <= RANK_TOLERANCE * eigenvalues[-1]
    return float("inf") if is_singular else float(eigenvalues[-1] / eigenvalues[0])


def log10_det(information: Float[ndarray, "columns columns"]) -> float:
    """J_d = log10 det Lambda, minus infinity where Lambda is singular."""
    sign, logarithm = np.linalg.slogdet(information)
    return float(logarithm / np.log(10)) if sign > 0 else -float("inf")


def trace_inverse(information: Float[ndarray, "columns columns"]) -> float:
    """A criterion: trace of the parameters' covariance, infinite where Lambda is singular."""
    eigenvalues = np.linalg.eigvalsh(information)
    is_singular = eigenvalues[0] <= RANK_TOLERANCE * eigenvalues[-1]
    return float("inf") if is_singular else float((1 / eigenvalues).sum())


def smallest_eigenvalue(information: Float[ndarray, "columns columns"]) -> float:
    """E criterion: the information about the least known direction."""
    return float(np.linalg.eigvalsh(information)[0])


def column_scaling(information: Float[ndarray, "columns columns"]) -> Float[ndarray, " columns"]:
    """Factors s that give S Lambda S a unit diagonal: every parameter in its own unit."""
    diagonal = np.diag(information)
    if not (diagonal > 0).all():
        raise ValueError(f"parameter {int(np.argmin(diagonal))} is not excited at all")
    return 1 / np.sqrt(diagonal)


def cost(information: Float[ndarray, "columns columns"], criterion: Criterion) -> float:
    """The criterion as a logarithm to be minimised.

    J_k: log10 cond, J_d: -log10 det, A: log10 trace of the inverse, E: -log10 of the smallest
    eigenvalue; infinite where Lambda is singular.
    """
    if criterion == "J_k":
        return float(np.log10(condition(information)))
    if criterion == "J_d":
        return -log10_det(information)
    if criterion == "A":
        return float(np.log10(trace_inverse(information)))
    if criterion == "E":
        smallest = smallest_eigenvalue(information)
        return -float(np.log10(smallest)) if smallest > 0 else float("inf")
    raise ValueError(f"criterion {criterion!r} is none of {CRITERIA}")


def value_of(cost: float, criterion: Criterion) -> float:
    """The criterion itself, of its `cost`: J_k, J_d, the trace of A or the eigenvalue of E."""
    if criterion == "J_d":
        return -cost
    return float(10.0 ** (-cost if criterion == "E" else cost))


def cost_and_slope(
    information: Float[ndarray, "columns columns"],
    criterion: Criterion,
    exponent: float = np.inf,
) -> tuple[float, Float[ndarray, "columns columns"]]:
    """`cost` and its gradient by the entries of Lambda.

    Args:
        information: Lambda.
        criterion: Which.
        exponent: p of the Schatten norms that stand in for the extreme eigenvalues in J_k and
            E: cond is replaced by (tr Lambda^p)^(1/p) (tr Lambda^-p)^(1/p), which is smooth, an
            upper bound, and exact in the limit. Of no effect on J_d and A.

    Returns:
        The cost, infinite with a zero gradient where Lambda is singular, and the symmetric
        gradient.
    """
    eigenvalues, vectors = np.linalg.eigh(information)
    if eigenvalues[0] <= RANK_TOLERANCE * eigenvalues[-1]:
        return float("inf"), np.zeros_like(information)
    logs = np.log(eigenvalues)
    if criterion == "J_d":
        value, weights = -logs.sum(), -np.ones_like(logs)
    elif criterion == "A":
        value, weights = soft_maximum(-logs, 1.0)
        weights = -weights
    elif criterion == "E":
        value, weights = soft_maximum(-logs, exponent)
        weights = -weights
    elif criterion == "J_k":
        largest, above = soft_maximum(logs, exponent)
        smallest, below = soft_maximum(-logs, exponent)
        value, weights = largest + smallest, above - below
    else:
        raise ValueError(f"criterion {criterion!r} is none of {CRITERIA}")
    slope = (vectors * (weights / eigenvalues)) @ vectors.T
    return float(value / np.log(10)), slope / np.log(10)


def soft_maximum(
    values: Float[ndarray, " columns"], exponent: float
) -> tuple[float, Float[ndarray, " columns"]]:
    """Logarithm of the p-norm of exp(values), and its gradient; the maximum itself for p = inf."""
    shifted = values - values.max()
    if np.isinf(exponent):
        weights = (shifted == 0.0).astype(float)
        return float(values.max()), weights / weights.sum()
    powers = np.exp(exponent * shifted)
    return float(values.max() + np.log(powers.sum()) / exponent), powers / powers.sum()
