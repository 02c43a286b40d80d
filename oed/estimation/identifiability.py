"""Which parameters the data determine, and why the others are not."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import independent_columns
from oed.estimation.triangular import triangularise, unit_columns

# Regressors are evaluated from positions differentiated numerically, with entries good to
# about ten digits: dependence to that accuracy is structure, not information.
DEPENDENT = 1e-10
# A 95 % interval of two standard deviations then just reaches zero.
LARGEST_RELATIVE_STD = 0.5
# A smaller share of a column than this in a combination is not worth printing.
SMALLEST_SHARE = 1e-6
NAMED_PARTNERS = 3


@dataclass(frozen=True)
class Identifiability:
    """A regressor's determined columns, and the evidence.

    Attributes:
        kept: (b,) columns that are linearly independent, in their original order.
        combination: (b, p) T with H = H[:, kept] T: the kept column's parameter stands for
            T xi, since adding to one and taking from another leaves the torque unchanged.
        names: (b,) readable combinations, the plain name where nothing is merged.
        removed: Names of the parameters that have no value of their own.
        reasons: One sentence for each of them.
        singular_values: (p,) of the regressor with unit columns, largest first.
    """

    kept: tuple[int, ...]
    combination: Float[ndarray, "b p"]
    names: tuple[str, ...]
    removed: tuple[str, ...]
    reasons: tuple[str, ...]
    singular_values: Float[ndarray, " p"]


def find_identifiable(
    regressor: Float[ndarray, "rows p"],
    names: tuple[str, ...],
    *,
    tolerance: float = DEPENDENT,
) -> Identifiability:
    """Find columns that are zero or depend on others, after scaling them to one norm.

    Of a dependent group every parameter is undetermined, but some combinations are not:
    one column for each is kept under the combination's name, earlier columns first.

    Args:
        regressor: H, or its triangular factor, which has the same dependences.
        names: (p,) parameter names.
        tolerance: Least distance of a unit column from the span of the kept ones.

    Raises:
        ValueError: If names and columns differ in number, or an entry is not finite.
    """
    columns = regressor.shape[1]
    if len(names) != columns:
        raise ValueError(f"{len(names)} names for {columns} columns")
    if not np.isfinite(regressor).all():
        raise ValueError("the regressor has entries that are not finite")
    factor, norms = unit_columns(triangularise(regressor))
    silent = np.linalg.norm(regressor, axis=0) == 0
    singular = np.linalg.svd(factor, compute_uv=False)
    rank = int(np.sum(singular > tolerance * singular[0]))
    # The earliest columns that reach the rank: the order of names is the caller's preference.
    kept = list(islice(independent_columns(factor, range(columns), tolerance), rank))
    combination = np.linalg.lstsq(factor[:, kept], factor, rcond=None)[0]
    combination[np.abs(combination) < SMALLEST_SHARE] = 0.0
    combination[:, kept] = np.eye(len(kept))
    combination *= norms / norms[kept][:, None]
    dropped = [c for c in range(columns) if c not in kept]
    merged = np.flatnonzero((combination[np.sum(combination != 0, axis=1) > 1] != 0).any(axis=0))
    undetermined = sorted({*merged.tolist(), *dropped})
    labels = tuple(_expression(row, names) for row in combination)
    return Identifiability(
        kept=tuple(kept),
        combination=combination,
        names=labels,
        removed=tuple(names[c] for c in undetermined),
        reasons=tuple(_reason(c, silent, combination, labels, singular) for c in undetermined),
        singular_values=singular,
    )


def badly_excited(
    names: tuple[str, ...],
    parameters: Float[ndarray, " p"],
    covariance: Float[ndarray, "p p"],
    information_factor: Float[ndarray, "p p"],
    *,
    threshold: float = LARGEST_RELATIVE_STD,
) -> dict[str, str]:
    """Parameters that are formally determined but whose value means little.

    A value is not worth quoting if its standard deviation exceeds a share of it. Whether the
    motion is to blame is shown by the variance inflation (Marquardt 1970; Belsley, Kuh &
    Welsch 1980): how much larger the variance is than it would be if no other column
    resembled this one. The parameter stays in the model, because leaving it out would
    bias those it is confounded with.

    Args:
        names: (p,).
        parameters: (p,) estimates.
        covariance: (p, p) of the estimates, by any method.
        information_factor: (p, p) R of the weighted rows.
        threshold: Largest relative standard deviation that passes.

    Returns:
        A sentence for each such parameter, by name.
    """
    std = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(std, std)
    scaled, _ = unit_columns(information_factor)
    inflation = np.sum(np.linalg.pinv(scaled) ** 2, axis=1)
    sentences = {}
    for c in np.flatnonzero(std > threshold * np.abs(parameters)):
        relative = f"{100 * std[c] / abs(parameters[c]):.3g} %" if parameters[c] else "infinite"
        others = [o for o in np.argsort(-np.abs(correlation[c])) if o != c][:NAMED_PARTNERS]
        partners = ", ".join(f"{names[o]} ({correlation[c, o]:+.2f})" for o in others)
        sentences[names[c]] = (
            f"badly excited or indistinguishable from zero: relative standard deviation {relative} "
            f"(more than {100 * threshold:g} %), variance inflated {inflation[c]:.3g} times by "
            f"other columns" + (f"; most correlated with {partners}" if partners else "")
        )
    return sentences


def hidden_errors(
    names: tuple[str, ...],
    parameters: Float[ndarray, " p"],
    spread: Float[ndarray, " p"],
    *,
    threshold: float = LARGEST_RELATIVE_STD,
) -> dict[str, str]:
    """Parameters that hang on directions which the data do not determine.

    Args:
        names: (p,).
        parameters: (p,) estimates.
        spread: (p,) by which an unseen error may move each, as `Reach.spread`.
        threshold: Largest share of the value that passes.

    Returns:
        A sentence for each such parameter, by name.
    """
    return {
        names[c]: (
            f"hardly excited by the recordings for estimation: an error as large as their residual "
            f"moves it by {spread[c]:.3g}, its value is {parameters[c]:.3g}"
        )
        for c in np.flatnonzero(spread > threshold * np.abs(parameters))
    }


def _expression(row: Float[ndarray, " p"], names: tuple[str, ...]) -> str:
    terms = np.flatnonzero(row).tolist()
    if len(terms) == 1:
        return names[terms[0]]
    first = next(c for c in terms if row[c] == 1.0)
    ordered = [first] + [c for c in terms if c != first]
    text = names[first]
    for c in ordered[1:]:
        factor = "" if np.isclose(abs(row[c]), 1.0) else f"{abs(row[c]):.4g}*"
        text += f" {'-' if row[c] < 0 else '+'} {factor}{names[c]}"
    return text


def _reason(
    column: int,
    silent: ndarray,
    combination: Float[ndarray, "b p"],
    labels: tuple[str, ...],
    singular: Float[ndarray, " p"],
) -> str:
    if silent[column]:
        return "no torque depends on it: its column is zero in all rows"
    groups = [label for row, label in zip(combination, labels, strict=True) if row[column] != 0]
    listed = " and ".join(groups)
    return (
        f"only {listed} is determined: of {len(singular)} singular values with unit columns "
        f"{len(labels)} are above rounding, {singular[len(labels) - 1]:.1e} being the least and "
        + (f"{singular[len(labels)]:.1e} the next" if len(labels) < len(singular) else "none next")
    )
