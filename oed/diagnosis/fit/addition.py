"""What a group of white columns adds to a fit: its part outside the span of the model.

A candidate is judged by that part alone (Frisch and Waugh), from the normal equations of the
group beside the model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.fit.linear_fit import Projection

# Share of a candidate's length outside the model below which it is absorbed: what is left is
# smoothing error, and a coefficient that stands on it means nothing.
ABSORBED = 1e-4
AT_ONCE = 64  # groups whose products are one

# White columns for each joint that they act on; of several groups each has its own number of them.
Group = Mapping[int, Float[ndarray, "rows columns"]]
Groups = Sequence[Mapping[int, Float[ndarray, "rows _"]]]


@dataclass(frozen=True)
class Addition:
    """What a group of columns adds to a fit.

    Attributes:
        gain: Fall of the sum of squares.
        coefficients: (m,) of the group's columns.
        rank: Columns that are not absorbed by the model.
    """

    gain: float
    coefficients: Float[ndarray, " columns"]
    rank: int


@dataclass(frozen=True)
class Directions:
    """Combinations of a group's columns that the model does not absorb.

    Attributes:
        lengths: (m,) of the whole columns; one of columns that are zero.
        squares: (k,) squared lengths of the combinations outside the model.
        mixing: (m, k) the combinations, orthonormal in columns of unit length.
    """

    lengths: Float[ndarray, " columns"]
    squares: Float[ndarray, " rank"]
    mixing: Float[ndarray, "columns rank"]

    @property
    def rank(self) -> int:
        """How many there are."""
        return len(self.squares)

    def along(self, moments: Float[ndarray, " columns *count"]) -> Float[ndarray, " rank *count"]:
        """Moments of the combinations from those of the columns."""
        return self.mixing.T @ (moments.T / self.lengths).T

    def gains(
        self, moments: Float[ndarray, "columns count"], ridge: float = 0.0
    ) -> Float[ndarray, " count"]:
        """Fall of the squares for each of many residuals, by their moments with the columns."""
        return np.sum(self.along(moments) ** 2 / (self.squares[:, None] + ridge), axis=0)

    def coefficients(
        self, moments: Float[ndarray, "columns count"]
    ) -> Float[ndarray, "columns count"]:
        """Of the columns, for each of these residuals."""
        return self.mixing @ (self.along(moments) / self.squares[:, None]) / self.lengths[:, None]


@dataclass(frozen=True)
class NormalEquations:
    """Of a group of columns beside a model.

    Attributes:
        gram: (m, m) of the columns' parts outside the model.
        lengths: (m,) squared lengths of the whole columns.
        moment: (m,) of the columns with the model's residual.
        inside: (b, m) of the columns with the model's basis.
    """

    gram: Float[ndarray, "columns columns"]
    lengths: Float[ndarray, " columns"]
    moment: Float[ndarray, " columns"]
    inside: Float[ndarray, "rank columns"]

    def squares(self, coefficients: Float[ndarray, " columns"]) -> float:
        """Of the columns together, by these coefficients: outside the model and inside."""
        outside = float(coefficients @ self.gram @ coefficients)
        return outside + float(np.sum((self.inside @ coefficients) ** 2))

    @cached_property
    def directions(self) -> Directions:
        """What is left of the group beside the model."""
        scale = np.sqrt(np.where(self.lengths > 0, self.lengths, 1.0))
        unit = self.gram / (scale[:, None] * scale)
        # Most groups are one column, to which a routine for matrices would be most of the work.
        single = len(unit) == 1
        values, vectors = (unit[0], np.ones((1, 1))) if single else np.linalg.eigh(unit)
        kept = values > ABSORBED**2 * len(values)
        return Directions(scale, values[kept], vectors[:, kept])

    def solved(self, ridge: float = 0.0) -> Addition:
        """Gain and coefficients.

        Args:
            ridge: Added to the Gram matrix of unit columns.
        """
        found = self.directions
        along = found.along(self.moment)
        inverse = 1 / (found.squares + ridge)
        coefficients = found.mixing @ (inverse * along) / found.lengths
        return Addition(float(np.sum(along**2 * inverse)), coefficients, found.rank)


def normal_equations(
    projection: Projection, residual: Float[ndarray, "joints rows"], group: Group
) -> NormalEquations:
    """The normal equations of a group of white columns beside a model.

    Args:
        projection: Of the model.
        residual: White residual of the model.
        group: White columns for each joint that they act on.
    """
    inside = sum(projection.basis[joint].T @ block for joint, block in group.items())
    return _equations(residual, group, np.asarray(inside))


def normal_equations_of_all(
    projection: Projection, residual: Float[ndarray, "joints rows"], groups: Groups
) -> list[NormalEquations]:
    """The same of many groups, at a fraction of the time: thin products wait for memory."""
    inside = moments_of_all(groups, projection.basis)
    return [_equations(residual, g, own.T) for g, own in zip(groups, inside, strict=True)]


def moments_of_all(
    groups: Groups, vectors: Float[ndarray, "joints rows count"]
) -> list[Float[ndarray, "_ count"]]:
    """Moments of each group's columns with many vectors: one product for all of a joint."""
    result = [np.zeros((_width(group), vectors.shape[2])) for group in groups]
    for start in range(0, len(groups), AT_ONCE):
        some = range(start, min(start + AT_ONCE, len(groups)))
        for joint, own_vectors in enumerate(vectors):
            own = [k for k in some if joint in groups[k]]
            if not own:
                continue
            blocks = [groups[k][joint] for k in own]
            ends = np.cumsum([block.shape[1] for block in blocks])
            products = np.split(np.concatenate(blocks, axis=1).T @ own_vectors, ends[:-1])
            for k, product in zip(own, products, strict=True):
                result[k] += product
    return result


def _width(group: Group) -> int:
    return next(iter(group.values())).shape[1]


def _equations(
    residual: Float[ndarray, "joints rows"], group: Group, inside: Float[ndarray, "rank columns"]
) -> NormalEquations:
    columns = _width(group)
    gram, moment = np.zeros((columns, columns)), np.zeros(columns)
    for joint, block in group.items():
        gram += block.T @ block
        moment += block.T @ residual[joint]
    lengths = np.diag(gram).copy()
    return NormalEquations(gram - inside.T @ inside, lengths, moment, inside)
