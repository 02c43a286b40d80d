"""Binary coding of decision variables (Calafiore 2001, eq. 13-14)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray


@dataclass(frozen=True)
class BinaryCoding:
    """Each variable an unsigned integer G of `bits` bits, most significant first.

    It stands for lower + G / (2^bits - 1) (upper - lower). On the box |a| <= a_max that is
    a = (2 A / (2^n_a - 1) - 1) a_max (13), on 0 <= omega <= omega_max it is
    omega = Omega / (2^n_omega - 1) omega_max (14), so decoding holds the bounds by itself.
    A genotype has the genes in the order of the variables, which for the harmonic class is the
    paper's [A_11 ... A_1W, A_21 ... A_nW, Omega_11 ... Omega_nW].

    Attributes:
        bounds: (size, 2) lower and upper bound of each variable, finite.
        bits: (size,) bits of each gene.

    Raises:
        ValueError: If a bound is not finite, a gene has no bit, or the sizes disagree.
    """

    bounds: Float[ndarray, "size 2"]
    bits: Int[ndarray, " genes"]

    def __post_init__(self) -> None:
        if len(self.bounds) != len(self.bits):
            raise ValueError(f"{len(self.bits)} genes for {len(self.bounds)} variables")
        if not np.isfinite(self.bounds).all():
            raise ValueError("every variable needs finite bounds to be coded")
        if (self.bits < 1).any() or (self.bits > 52).any():
            raise ValueError(
                f"bits from {self.bits.min()} to {self.bits.max()}: 1 to 52 make sense"
            )

    @property
    def length(self) -> int:
        """Bits of a genotype."""
        return int(self.bits.sum())

    @cached_property
    def weights(self) -> Float[ndarray, "length size"]:
        """Value of each bit in each gene's integer: integers = genotype @ weights."""
        weights = np.zeros((self.length, len(self.bits)))
        first = 0
        for gene, bits in enumerate(self.bits):
            weights[first : first + bits, gene] = 2.0 ** np.arange(bits - 1, -1, -1)
            first += bits
        return weights

    def integers(self, genotypes: Bool[ndarray, "*population length"]) -> ndarray:
        """The unsigned integer of each gene, (..., size)."""
        return genotypes @ self.weights

    def decode(self, genotypes: Bool[ndarray, "*population length"]) -> ndarray:
        """The variables (..., size) that genotypes stand for."""
        lower, upper = self.bounds.T
        return lower + self.integers(genotypes) / (2.0**self.bits - 1) * (upper - lower)

    def random(self, count: int, rng: np.random.Generator) -> Bool[ndarray, "count length"]:
        """Independent uniform genotypes."""
        return rng.random((count, self.length)) < 0.5
