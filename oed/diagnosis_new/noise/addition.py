"""What a group of white columns adds to a fit: its part outside the span of the model.

A candidate is judged by that part alone (Frisch and Waugh), from the normal equations of the
group beside the model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis_new.noise.linear_fit import Projection

# Share of a candidate's length outside the model below which it is absorbed: what is left is
# smoothing error, and a coefficient that stands on it means nothing.
ABSORBED = 1e-4
AT_ONCE = 64  # groups whose products are one

# White columns for each joint that they act on; of several groups each has its own number of them.
Group = Mapping[int, Float[ndarray, "rows columns"]]
Groups = Sequence[Mapping[int, Float[ndarray, "rows _"]]]
Ridge = float | Float[ndarray, " groups"]


@dataclass(frozen=True)
class Addition:
    """What a group of columns adds to a fit.

    Attributes:
        gain: Fall of the sum of squares.
        coefficients: (m,) of the group's columns.
        rank: Columns that are not absorbed by the model.
        squares: Of the columns together by these coefficients, outside the model and inside.
    """

    gain: float
    coefficients: Float[ndarray, " columns"]
    rank: int
    squares: float


@dataclass(frozen=True)
class Directions:
    """Combinations of a group's columns outside the model, or of each of several groups.

    Attributes:
        lengths: (..., m) of the whole columns; one of columns that are zero.
        squares: (..., m) squared lengths of the combinations outside the model; infinite of those
            that it absorbs, so that they explain nothing.
        mixing: (..., m, m) the combinations, orthonormal in columns of unit length.
    """

    lengths: Float[ndarray, "*groups columns"]
    squares: Float[ndarray, "*groups columns"]
    mixing: Float[ndarray, "*groups columns columns"]

    @property
    def rank(self) -> Int[ndarray, "*groups"]:
        """How many the model does not absorb."""
        return np.asarray(np.isfinite(self.squares).sum(axis=-1))

    def along(
        self, moments: Float[ndarray, "*groups columns count"]
    ) -> Float[ndarray, "*groups columns count"]:
        """Moments of the combinations from those of the columns."""
        return self.mixing.swapaxes(-1, -2) @ (moments / self.lengths[..., None])

    def gains(
        self, moments: Float[ndarray, "*groups columns count"], ridge: Ridge = 0.0
    ) -> Float[ndarray, "*groups count"]:
        """Fall of the squares for each of many residuals, by their moments with the columns."""
        return np.sum(self.along(moments) ** 2 / self._with(ridge), axis=-2)

    def coefficients(
        self, moments: Float[ndarray, "*groups columns count"], ridge: Ridge = 0.0
    ) -> Float[ndarray, "*groups columns count"]:
        """Of the columns, for each of these residuals."""
        return self.mixing @ (self.along(moments) / self._with(ridge)) / self.lengths[..., None]

    def _with(self, ridge: Ridge) -> Float[ndarray, "*groups columns 1"]:
        return (self.squares + np.asarray(ridge)[..., None])[..., None]


@dataclass(frozen=True)
class NormalEquations:
    """Of a group of columns beside a model, or of each of several groups.

    Attributes:
        gram: (..., m, m) of the columns' parts outside the model.
        lengths: (..., m) squared lengths of the whole columns.
        moment: (..., m) of the columns with the model's residual.
        inside: (..., b, m) of the columns with the model's basis.
    """

    gram: Float[ndarray, "*groups columns columns"]
    lengths: Float[ndarray, "*groups columns"]
    moment: Float[ndarray, "*groups columns"]
    inside: Float[ndarray, "*groups rank columns"]

    @cached_property
    def directions(self) -> Directions:
        """What is left of the columns beside the model."""
        scale = np.sqrt(np.where(self.lengths > 0, self.lengths, 1.0))
        unit = self.gram / (scale[..., :, None] * scale[..., None, :])
        # Most groups are one column, to which a routine for matrices would be most of the work.
        single = unit.shape[-1] == 1
        values, vectors = (unit[..., 0], np.ones_like(unit)) if single else np.linalg.eigh(unit)
        absorbed = values <= ABSORBED**2 * values.shape[-1]
        return Directions(scale, np.where(absorbed, np.inf, values), vectors)

    def solved(self, ridge: float = 0.0) -> Addition:
        """Gain and coefficients of one group.

        Args:
            ridge: Added to the Gram matrix of unit columns.
        """
        return self.in_a_row().each_solved(np.array([ridge]))[0]

    def each_solved(self, ridges: Float[ndarray, " groups"]) -> list[Addition]:
        """The same of several groups, with a ridge for each."""
        found, moments = self.directions, self.moment[..., None]
        coefficients = found.coefficients(moments, ridges)
        outside = np.sum(coefficients * (self.gram @ coefficients), axis=(1, 2))
        inside = np.sum((self.inside @ coefficients) ** 2, axis=(1, 2))
        gains = np.sum(moments * coefficients, axis=(1, 2))
        numbers = (gains.tolist(), found.rank.tolist(), (outside + inside).tolist())
        return [
            Addition(gain, own, rank, squares)
            for own, gain, rank, squares in zip(coefficients[..., 0], *numbers, strict=True)
        ]

    def in_a_row(self) -> NormalEquations:
        """One group as the only one of several."""
        own = (self.gram, self.lengths, self.moment, self.inside)
        return NormalEquations(*(x[None] for x in own))

    def some(self, places: Sequence[int]) -> NormalEquations:
        """Those of several groups that have these places."""
        own = (self.gram, self.lengths, self.moment, self.inside)
        return NormalEquations(*(x[list(places)] for x in own))


def normal_equations(
    projection: Projection, residual: Float[ndarray, "joints rows"], group: Group
) -> NormalEquations:
    """The normal equations of a group of white columns beside a model.

    Args:
        projection: Of the model.
        residual: White residual of the model.
        group: White columns for each joint that they act on.
    """
    inside = np.asarray(sum(projection.basis[j].T @ block for j, block in group.items()))
    moment = np.asarray(sum(block.T @ residual[j] for j, block in group.items()))
    return _equations(gram_of(group), moment, inside)


def gram_of(group: Group) -> Float[ndarray, "columns columns"]:
    """Products of a group's columns with one another."""
    return np.asarray(sum(block.T @ block for block in group.values()))


def normal_equations_of_all(
    projection: Projection,
    residual: Float[ndarray, "joints rows"],
    groups: Groups,
    grams: Sequence[Float[ndarray, "_ _"]],
) -> list[tuple[list[int], NormalEquations]]:
    """The same of many groups, at a fraction of the time: thin products wait for memory.

    Args:
        projection: Of the model.
        residual: White residual of the model.
        groups: White columns, each for the joints that they act on.
        grams: Of each group.

    Returns:
        The places of those of as many columns, with the normal equations of each of them.
    """
    vectors = np.concatenate([projection.basis, residual[:, :, None]], axis=2)
    moments = moments_of_all(groups, vectors)
    found = []
    for places in _of_one_width(groups):
        own = np.stack([moments[k] for k in places])
        inside = np.ascontiguousarray(own[..., :-1].swapaxes(-1, -2))
        gram = np.stack([grams[k] for k in places])
        found.append((places, _equations(gram, own[..., -1], inside)))
    return found


def _of_one_width(groups: Groups) -> list[list[int]]:
    """Places of the groups, those of as many columns together."""
    by_width: dict[int, list[int]] = {}
    for place, group in enumerate(groups):
        by_width.setdefault(_width(group), []).append(place)
    return list(by_width.values())


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
    gram: Float[ndarray, "*groups columns columns"],
    moment: Float[ndarray, "*groups columns"],
    inside: Float[ndarray, "*groups rank columns"],
) -> NormalEquations:
    lengths = np.diagonal(gram, axis1=-2, axis2=-1).copy()
    return NormalEquations(gram - inside.swapaxes(-1, -2) @ inside, lengths, moment, inside)
