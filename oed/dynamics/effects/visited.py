"""Where in a term's coordinates a motion has been, and how the term ends beyond.

A function that was read off where the arm went says nothing of where it did not. Some carry over
the edge as they are, others are of quite another size there: how far one is to be trusted only
another motion tells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial import KDTree

CELL = 0.02  # of a coordinate's range


@dataclass(frozen=True)
class Visited:
    """A region as the cells that a motion went through, and the distance over which a term ends.

    Attributes:
        cells: (c, k) their centres, in units of a cell.
        lower: (k,) least values.
        size: (k,) of a cell.
        fading: Standard deviation of the Gaussian by which the term falls, in ranges.
    """

    cells: Float[ndarray, "cells coordinates"]
    lower: Float[ndarray, " coordinates"]
    size: Float[ndarray, " coordinates"]
    fading: float

    @classmethod
    def of(cls, values: Float[ndarray, "samples coordinates"], fading: float) -> Visited:
        """The region that some samples lie in.

        Args:
            values: Of the coordinates.
            fading: Distance over which a term ends beyond, in ranges of the coordinates.
        """
        lower, upper = values.min(axis=0), values.max(axis=0)
        size = CELL * np.maximum(upper - lower, 1e-6)
        cells = np.unique(np.floor((values - lower) / size), axis=0) + 0.5
        return cls(cells, lower, size, fading)

    def weight(self, values: Float[ndarray, "samples coordinates"]) -> Float[ndarray, " samples"]:
        """One in the region, falling to zero beyond."""
        distance, _ = KDTree(self.cells).query((values - self.lower) / self.size)
        corner = np.sqrt(len(self.lower)) / 2  # of a cell, from its centre
        beyond = CELL * np.maximum(distance - corner, 0.0)
        return np.exp(-((beyond / self.fading) ** 2) / 2)
