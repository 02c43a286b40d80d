"""Base parameters: the combinations that a motion can reveal, and nothing else.

Gautier and Khalil 1990, "Direct calculation of minimum set of inertial parameters of serial
robots", and Gautier 1991, "Numerical calculation of the base inertial parameters of robots":
a column that is a combination of others is regrouped into them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.effects import Parameter
from oed.errors import RankUndetermined

# Singular values, and lengths of columns, below this fraction of the largest count as zero.
RANK_TOLERANCE = 1e-8
# A regrouping coefficient below this is rounding: it moves no torque that can be measured.
NEGLIGIBLE = 1e-9
# Length of a normalised column outside the span of others from which it counts as new: the
# square root of rounding separates structural dependence from the weakest real one.
INDEPENDENT = 1e-7


@dataclass(frozen=True)
class BaseParameters:
    """A regrouping of p parameters into b that are identifiable.

    Attributes:
        columns: (b,) indices of the columns that represent the regressor.
        regrouping: (b, p) matrix K with beta = K pi and W = W[:, columns] K.
        singular_values: (p,) of the normalised regressor, largest first: the evidence.
        names: (b,) names of the representing parameters.
        expressions: (b,) what each base parameter stands for, such as "Izz_1 + 0.359^2 m_2".
        units: (b,) units.
        joints: (b,) joint of each representing parameter, None for the whole arm.
        note: How the rank was decided, where that needs saying.
    """

    columns: Int[ndarray, " base"]
    regrouping: Float[ndarray, "base parameters"]
    singular_values: Float[ndarray, " parameters"]
    names: tuple[str, ...]
    expressions: tuple[str, ...]
    units: tuple[str, ...]
    joints: tuple[int | None, ...]
    note: str = ""

    def __len__(self) -> int:
        return len(self.columns)

    def reduce(self, regressor: Float[ndarray, "*rows parameters"]) -> Float[ndarray, "*rows base"]:
        """The base columns of a full regressor."""
        return regressor[..., self.columns]

    def from_standard(self, parameters: Float[ndarray, " parameters"]) -> Float[ndarray, " base"]:
        """Base parameters of a full parameter vector."""
        return self.regrouping @ parameters

    def to_standard(self, base: Float[ndarray, " base"]) -> Float[ndarray, " parameters"]:
        """The full vector with these base parameters in which all regrouped ones are zero."""
        full = np.zeros(self.regrouping.shape[1])
        full[self.columns] = base
        return full


def find_base_parameters(
    regressor: Float[ndarray, "rows parameters"],
    parameters: Sequence[Parameter],
    *,
    preference: Sequence[int] | None = None,
    lengths: Sequence[float] = (),
    tolerance: float = RANK_TOLERANCE,
    gap: float = 1e3,
) -> BaseParameters:
    """Find the base parameters that a stacked regressor reveals.

    Args:
        regressor: W, one row per sample and joint [N m per unit of each parameter]. Sample
            it at random motions: the result must describe the robot, not one trajectory.
        parameters: The p parameters of its columns.
        preference: Column indices, those to keep first; left to right if None.
        lengths: Kinematic lengths [m] by which coefficients are made readable.
        tolerance: Singular values below this fraction of the largest count as zero.
        gap: Least ratio of the last kept to the first dropped singular value.

    Raises:
        ValueError: If there are fewer rows than columns.
        RankUndetermined: If that ratio is below `gap`.
    """
    rows, count = regressor.shape
    if rows < count:
        raise ValueError(f"{rows=} cannot reveal the rank of {count=} columns")
    factor, norms = normalised_factor(regressor, tolerance)
    singular_values = np.linalg.svd(factor, compute_uv=False)
    rank = _rank(singular_values, tolerance, gap)
    order = range(count) if preference is None else preference
    kept = list(independent_columns(factor, order, INDEPENDENT))
    if len(kept) != rank:
        raise RankUndetermined(
            f"{len(kept)} columns are independent one by one, but the singular values say {rank}",
            singular_values,
        )
    normalised = np.linalg.lstsq(factor[:, kept], factor, rcond=None)[0]
    normalised[np.abs(normalised) < NEGLIGIBLE] = 0.0
    normalised[:, kept] = np.eye(rank)
    regrouping = normalised * np.where(np.isfinite(norms), norms, 0.0) / norms[kept][:, None]
    names = [parameter.name for parameter in parameters]
    return BaseParameters(
        columns=np.array(kept),
        regrouping=regrouping,
        singular_values=singular_values,
        names=tuple(names[c] for c in kept),
        expressions=tuple(
            _expression(regrouping[row], names, c, lengths) for row, c in enumerate(kept)
        ),
        units=tuple(parameters[c].unit for c in kept),
        joints=tuple(parameters[c].joint for c in kept),
    )


def normalised_factor(
    regressor: Float[ndarray, "rows parameters"], tolerance: float = RANK_TOLERANCE
) -> tuple[Float[ndarray, "parameters parameters"], Float[ndarray, " parameters"]]:
    """Triangular factor of a regressor with unit columns, and the columns' lengths.

    Columns mix kg, kg m and kg m^2: normalised, units cannot move the rank. A column of
    pure rounding becomes a zero column of infinite length rather than a blown-up one.
    """
    norms = np.linalg.norm(regressor, axis=0)
    norms = np.where(norms > tolerance * norms.max(initial=0.0), norms, np.inf)
    return np.asarray(np.linalg.qr(regressor / norms, mode="r")), norms


def _rank(singular_values: Float[ndarray, " parameters"], tolerance: float, gap: float) -> int:
    rank = int((singular_values > tolerance * singular_values[0]).sum())
    if rank < len(singular_values):
        kept, dropped = singular_values[rank - 1], singular_values[rank]
        if kept < gap * dropped:
            raise RankUndetermined(
                f"no clear gap in the singular values: number {rank} is {kept:.3g}, "
                f"number {rank + 1} is {dropped:.3g}, ratio below {gap:g}",
                singular_values,
            )
    return rank


def independent_columns(
    factor: Float[ndarray, "rows columns"], order: Iterable[int], tolerance: float
) -> Iterator[int]:
    """Columns, taken in order, that are no combination of those before them.

    Args:
        factor: With unit columns.
        order: In which to take them.
        tolerance: Least length of a column outside the span of those before it.
    """
    basis = np.zeros((factor.shape[0], 0))
    for column in order:
        rest = factor[:, column]
        for _ in range(2):  # twice is enough against cancellation (Kahan; Giraud et al. 2005)
            rest = rest - basis @ (basis.T @ rest)
        length = np.linalg.norm(rest)
        if length > tolerance:
            yield column
            basis = np.column_stack([basis, rest / length])


def _expression(
    row: Float[ndarray, " parameters"],
    names: Sequence[str],
    kept: int,
    lengths: Sequence[float],
) -> str:
    """The regrouped parameter in words: the kept name first, then what joins it."""
    text = names[kept]
    for column in np.flatnonzero(row).tolist():
        if column != kept:
            sign = "-" if row[column] < 0 else "+"
            text += f" {sign} {_coefficient(abs(row[column]), lengths)}{names[column]}"
    return text


def _coefficient(value: float, lengths: Sequence[float]) -> str:
    """A coefficient as a length, its square or its double where it is one."""
    if abs(value - 1.0) < NEGLIGIBLE:
        return ""
    # A length before twice another that is half as long.
    for form, factor, power in (("{:g}", 1.0, 1), ("{:g}^2", 1.0, 2), ("2 {:g}", 2.0, 1)):
        for length in lengths:
            if abs(value - factor * length**power) < NEGLIGIBLE:
                return f"{form.format(length)} "
    return f"{value:.6g} "
