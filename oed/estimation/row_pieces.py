"""The rows of a regressor, a piece at a time, so that memory does not grow with the samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import accumulate, pairwise

import numpy as np
from jaxtyping import Float
from numpy import ndarray

# Of one piece; a pass over the rows has about six arrays as large at once, a third of a gigabyte.
PIECE_BYTES = 64_000_000
# Of the pieces that are kept from pass to pass. With the recordings themselves and what Python loads,
# a million rows of seven joints stay below two gigabytes.
HELD_BYTES = 256_000_000
FLOAT_BYTES = 8

Evaluate = Callable[[], Float[ndarray, "rows p"]]


@dataclass(frozen=True, eq=False)
class RowPieces:
    """A regressor whose rows are given piece after piece, as often as they are asked for.

    Attributes:
        evaluate: One function a piece, which returns its rows, sample-major.
        lengths: Samples of each piece.
        joints: n; a piece of N samples has N n rows.
        columns: p.
    """

    evaluate: tuple[Evaluate, ...]
    lengths: tuple[int, ...]
    joints: int
    columns: int

    @classmethod
    def of(
        cls,
        regressor: Float[ndarray, "rows p"] | RowPieces,
        joints: int,
        segments: tuple[int, ...] | None = None,
    ) -> RowPieces:
        """Pieces of an array, which are views of it; what comes in pieces stays as it is.

        Args:
            regressor: Sample-major.
            joints: n.
            segments: Samples of each piece; one piece if None.

        Raises:
            ValueError: If the rows are not whole samples, or the segments do not add up to them.
        """
        if isinstance(regressor, RowPieces):
            return regressor
        rows, columns = regressor.shape
        if joints < 1 or rows % joints:
            raise ValueError(f"{rows} rows are not a multiple of {joints} joints")
        samples = rows // joints
        lengths = (samples,) if segments is None else segments
        if sum(lengths) != samples or min(lengths) < 1:
            raise ValueError(f"segments {lengths} do not add up to {samples} samples")
        pieces = np.split(regressor, joints * np.cumsum(lengths)[:-1])
        return cls(tuple(partial(_given, piece) for piece in pieces), lengths, joints, columns)

    @property
    def rows(self) -> int:
        """Of all pieces together."""
        return self.joints * sum(self.lengths)

    @property
    def size(self) -> int:
        """Of all pieces, were they held [bytes]."""
        return FLOAT_BYTES * self.rows * self.columns

    @property
    def places(self) -> tuple[slice, ...]:
        """Of each piece's rows among all."""
        ends = accumulate((self.joints * length for length in self.lengths), initial=0)
        return tuple(slice(first, last) for first, last in pairwise(ends))

    def __iter__(self) -> Iterator[Float[ndarray, "rows p"]]:
        """One pass over all rows."""
        return (evaluate() for evaluate in self.evaluate)

    def placed(self) -> Iterator[tuple[slice, Float[ndarray, "rows p"]]]:
        """The same, with the place of each piece's rows among all."""
        return zip(self.places, self, strict=True)

    def influences(self) -> Iterator[Float[ndarray, "samples joints p"]]:
        """The same, with an axis for the joints."""
        return (piece.reshape(-1, self.joints, self.columns) for piece in self)

    def changed(
        self,
        change: Callable[[Float[ndarray, "rows p"], slice], Float[ndarray, "rows q"]],
        columns: int,
    ) -> RowPieces:
        """With a function of each piece's rows and their place, applied in each pass.

        Args:
            change: Must not write into its argument.
            columns: q that it returns.
        """
        pairs = zip(self.evaluate, self.places, strict=True)
        changed = tuple(partial(_changed, evaluate, change, place) for evaluate, place in pairs)
        return RowPieces(changed, self.lengths, self.joints, columns)

    def times(self, matrix: Float[ndarray, "p q"]) -> RowPieces:
        """The rows times a matrix."""
        return self.changed(lambda piece, _: piece @ matrix, matrix.shape[1])

    def only(self, columns: Sequence[int]) -> RowPieces:
        """These columns."""
        places = list(columns)
        return self.changed(lambda piece, _: piece[:, places], len(places))

    def predict(self, parameters: Float[ndarray, " p"]) -> Float[ndarray, "samples joints"]:
        """The torque of parameters, in one pass [N m]."""
        torque = np.concatenate([piece @ parameters for piece in self])
        return torque.reshape(-1, self.joints)

    def held(self, most: int = HELD_BYTES) -> RowPieces:
        """The same, the first pieces evaluated once and kept, as many as these bytes hold."""
        kept, left = [], most
        for evaluate, length in zip(self.evaluate, self.lengths, strict=True):
            left -= FLOAT_BYTES * length * self.joints * self.columns
            kept.append(partial(_given, evaluate()) if left >= 0 else evaluate)
        return RowPieces(tuple(kept), self.lengths, self.joints, self.columns)


def even_pieces(samples: int, joints: int, columns: int) -> tuple[slice, ...]:
    """Stretches of about one length that a recording is cut into, each of `PIECE_BYTES` at most."""
    count = -(-samples * joints * columns * FLOAT_BYTES // PIECE_BYTES)
    ends = np.linspace(0, samples, max(count, 1) + 1).round().astype(int).tolist()
    return tuple(slice(first, last) for first, last in pairwise(ends))


def _given(piece: Float[ndarray, "rows p"]) -> Float[ndarray, "rows p"]:
    return piece


def _changed(
    evaluate: Evaluate,
    change: Callable[[Float[ndarray, "rows p"], slice], Float[ndarray, "rows q"]],
    place: slice,
) -> Float[ndarray, "rows q"]:
    return change(evaluate(), place)
