"""Test functions phi(q, dq), whose rate has mean zero over every periodic motion."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion


@dataclass(frozen=True)
class Monomials:
    """phi_k = prod_j q_j^e v_j^f in scaled coordinates, and d phi_k / dt.

    Any choice of them leaves the bound valid; more make it tighter.

    Attributes:
        centre: (n,) position at the middle of each joint's range [rad or m].
        scale: (2 n,) units of q_1 ... q_n, v_1 ... v_n, such as their largest values.
        exponents: (m, 2 n) powers of q_1 ... q_n, v_1 ... v_n.
    """

    centre: Float[ndarray, " joints"]
    scale: Float[ndarray, " twice"]
    exponents: Int[ndarray, "functions twice"]

    @classmethod
    def up_to(
        cls,
        degree: int,
        centre: Float[ndarray, " joints"],
        scale: Float[ndarray, " twice"],
        *,
        even: bool = True,
    ) -> Monomials:
        """All monomials up to a total degree that are odd in the velocities together.

        A motion run backwards has the same log det if friction is odd in velocity, and the mean
        of both is better: functions even in velocity balance by themselves. So do those of odd
        degree where q -> -q maps the problem onto itself.

        Args:
            degree: Highest total degree.
            centre: See the class.
            scale: See the class.
            even: Whether to leave out those of odd total degree.
        """
        n = len(centre)
        kept = [
            powers
            for powers in itertools.product(range(degree + 1), repeat=2 * n)
            if sum(powers) <= degree and sum(powers[n:]) % 2 == 1 and not (even and sum(powers) % 2)
        ]
        kept.sort(key=sum)
        return cls(centre, scale, np.array(kept, dtype=int).reshape(-1, 2 * n))

    def __len__(self) -> int:
        return len(self.exponents)

    @cached_property
    def highest(self) -> int:
        """Largest power that occurs."""
        return int(self.exponents.max(initial=0))

    def rates(self, motion: Motion) -> Float[ndarray, "samples functions"]:
        """D phi_k / dt in every state."""
        n = len(self.centre)
        values = np.concatenate([motion.q - self.centre, motion.dq], axis=1) / self.scale
        slopes = np.concatenate([motion.dq, motion.ddq], axis=1) / self.scale
        powers = values[:, :, None] ** np.arange(self.highest + 1)
        rates = np.zeros((len(motion), len(self)))
        for k, exponents in enumerate(self.exponents):
            for i in np.flatnonzero(exponents):
                term = exponents[i] * slopes[:, i] * powers[:, i, exponents[i] - 1]
                for other in range(2 * n):
                    if other != i and exponents[other]:
                        term = term * powers[:, other, exponents[other]]
                rates[:, k] += term
        return rates

    def symbolic_sum(
        self, coefficients: Float[ndarray, " functions"], q: casadi.SX, v: casadi.SX
    ) -> casadi.SX:
        """sum_k coefficients_k phi_k, nested in the way of Horner."""
        values = casadi.vertsplit(casadi.vertcat(q - self.centre, v) * (1 / self.scale))
        terms = {
            tuple(map(int, e)): float(c) for e, c in zip(self.exponents, coefficients, strict=True)
        }
        return _nested(terms, values)


def _nested(terms: dict[tuple[int, ...], float], values: list[casadi.SX]) -> casadi.SX:
    """A polynomial in the last variable whose coefficients are polynomials in the others."""
    if not values:
        return casadi.SX(sum(terms.values()))
    by_power: dict[int, dict[tuple[int, ...], float]] = {}
    for powers, coefficient in terms.items():
        by_power.setdefault(powers[-1], {})[powers[:-1]] = coefficient
    result = casadi.SX(0)
    for power in range(max(by_power, default=0), -1, -1):
        result = result * values[-1]
        if power in by_power:
            result = result + _nested(by_power[power], values[:-1])
    return result
