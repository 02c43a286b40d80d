"""What noise there is without repetitions: what even a rich smooth fit of a joint leaves.

Splines in every coordinate by itself come first. Products of two coordinates, fine splines along a
turn, and friction that falls from rest or is another in each recording join only where they
explain far more than correlated noise would give them: every further function also follows some
noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.estimation.noise_floor.colour import Colour, Stretches, noise_along, power_of_noise
from oed.estimation.noise_floor.linear_fit import LinearFit
from oed.estimation.noise_floor.rich_columns import first_blocks, further_blocks
from oed.experiment.preparation.prepared import Prepared

ROWS_PER_FREE_COLUMN = 8  # least rows for each column of the first fit
LEAST_ROWS_PER_COLUMN = 4  # and after the enrichment
# Least ratio of what a column of a further term explains to what one of correlated noise would.
CONVINCING = 3.0
MOST_FURTHER = 4
NEW = 1e-9  # squared share of a unit column outside a span, below which it adds nothing to it


@dataclass(frozen=True)
class RichFit:
    """A rich fit of one joint.

    Attributes:
        residual: (R,) what it leaves, one recording after another; zero in rows that were
            not fitted [N m].
        rank: Columns that the data determine.
        colour: Of the noise that was there.
    """

    residual: Float[ndarray, " rows"]
    rank: int
    colour: Colour


def rich_fit(
    fit: LinearFit,
    prepared: Sequence[Prepared],
    joint: int,
    *,
    own: Float[ndarray, "rows columns"],
    torque: Float[ndarray, " rows"],
    trusted: Bool[ndarray, " rows"],
    enriched: bool = True,
) -> RichFit:
    """Fit base columns and smooth terms to one joint's torque.

    Args:
        fit: Of the base model.
        prepared: The recordings.
        joint: Index.
        own: Filtered columns of the joint that its model brings.
        torque: Of the rows, less what is known to come from elsewhere [N m].
        trusted: Rows where the direction of motion is certain; the others are not fitted.
        enriched: Whether products and fine splines may join.
    """
    rows = int(trusted.sum())
    stretches = Stretches((0, *np.cumsum([p.rows for p in prepared]).tolist()), trusted)
    most = max(10, rows // ROWS_PER_FREE_COLUMN - len(fit.columns) // fit.model.robot.n)
    first = first_blocks(tuple(prepared), joint)
    while len(first) > 1 and sum(block.shape[1] for block in first) > most:
        first.pop()
    span = _basis(_of_unit_length(np.concatenate([own, *first], axis=1)[trusted]))
    left = torque[trusted] - span @ (span.T @ torque[trusted])
    taken = stretches.taken_by(span)
    if enriched:
        further = further_blocks(tuple(prepared), joint)
        tried = Additions.of([block[trusted] for block in further]).outside(span)
        for _ in range(MOST_FURTHER):
            shares = tried.taken(stretches)
            ratios = tried.convincing(left, taken, shares, stretches)
            best = int(np.argmax(ratios))
            new = tried.columns[:, tried.places[best]]
            if (
                ratios[best] < CONVINCING
                or span.shape[1] + new.shape[1] > rows // LEAST_ROWS_PER_COLUMN
            ):
                break
            taken = [x + own[:, best] for x, own in zip(taken, shares, strict=True)]
            left = left - new @ (new.T @ left)
            span = np.concatenate([span, new], axis=1)
            tried = tried.without(best).outside(new)
    return RichFit(stretches.whole(left), span.shape[1], Colour.of(left, taken, stretches))


@dataclass(frozen=True)
class Additions:
    """What may join a span, looked at side by side.

    Attributes:
        columns: Of all, one after another, each of unit length or zero.
        widths: Columns of each.
    """

    columns: Float[ndarray, "seen_rows columns"]
    widths: tuple[int, ...]

    @classmethod
    def of(cls, blocks: Sequence[Float[ndarray, "seen_rows _"]]) -> Additions:
        """Of the columns of each, whatever their lengths."""
        columns = _of_unit_length(np.concatenate(blocks, axis=1))
        return cls(columns, tuple(block.shape[1] for block in blocks))

    @property
    def places(self) -> tuple[slice, ...]:
        """Of each one's columns among all."""
        return tuple(slice(a, b) for a, b in pairwise(accumulate(self.widths, initial=0)))

    def without(self, k: int) -> Additions:
        """The others."""
        others = np.delete(self.columns, self.places[k], axis=1)
        return Additions(others, self.widths[:k] + self.widths[k + 1 :])

    def outside(self, span: Float[ndarray, "seen_rows rank"]) -> Additions:
        """Orthonormal bases of what each adds to a span."""
        # Once is enough: what is kept is so long that rounding leaves 1e-11 of it inside.
        columns = self.columns - span @ (span.T @ self.columns)
        bases = [_basis(columns[:, place]) for place in self.places]
        return Additions(np.concatenate(bases, axis=1), tuple(basis.shape[1] for basis in bases))

    def summed(self, products: Float[ndarray, "rows columns"]) -> Float[ndarray, "rows additions"]:
        """Sums over the columns of each of something that every column has."""
        found = np.zeros((len(products), len(self.widths)))
        filled = np.array(self.widths) > 0  # of no columns, `reduceat` gives the one that follows
        starts = [place.start for place in self.places]
        if filled.any():
            found[:, filled] = np.add.reduceat(products, np.array(starts)[filled], axis=1)
        return found

    def taken(self, stretches: Stretches) -> list[Float[ndarray, "frequencies additions"]]:
        """Share of the noise that each takes, of each recording.

        Args:
            stretches: Where they look.
        """
        return [self.summed(squares) for squares in stretches.squares(self.columns)]

    def convincing(
        self,
        before: Float[ndarray, " seen_rows"],
        taken: Sequence[Float[ndarray, " _"]],
        own: Sequence[Float[ndarray, "_ additions"]],
        stretches: Stretches,
    ) -> Float[ndarray, " additions"]:
        """Squares that each explains, over those of noise of the colour that it leaves.

        Args:
            before: What is left without them.
            taken: Share of the noise that the span takes.
            own: That each takes besides.
            stretches: Where they look.
        """
        moments = self.columns.T @ before
        explained = [self.columns[:, place] @ moments[place] for place in self.places]
        left = before[:, None] - np.stack(explained, axis=1)
        both = [x[:, None] + y for x, y in zip(taken, own, strict=True)]
        noise = noise_along(power_of_noise(left, both, stretches), own, stretches)
        return self.summed(moments[None] ** 2)[0] / np.maximum(noise, 1e-300)


def _of_unit_length(columns: Float[ndarray, "rows columns"]) -> Float[ndarray, "rows columns"]:
    norms = np.linalg.norm(columns, axis=0)
    return columns / np.where(norms > 0, norms, 1.0)


def _basis(columns: Float[ndarray, "rows columns"]) -> Float[ndarray, "rows rank"]:
    """Orthonormal basis of what is left of columns that had unit length."""
    values, vectors = np.linalg.eigh(columns.T @ columns)
    kept = values > NEW
    return columns @ (vectors[:, kept] / np.sqrt(values[kept]))
