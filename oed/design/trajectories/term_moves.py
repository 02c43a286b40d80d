"""Moves of single terms of a sum of sines, from which a local solver may find a better one.

Local optima of sums with free frequencies differ in what each sine is there for, and two sines
of nearly one frequency make a single one whose amplitude and phase change slowly.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

RELATIVE_SPLIT = 0.1  # standard deviation of the ratio of two near frequencies
OVERTONES = (1 / 3, 1 / 2, 2.0, 3.0, 5.0)  # ratios of a term's frequency to another's
OVERTONE_STRENGTH = 0.3  # greatest acceleration of an overtone, relative to its root's


@runtime_checkable
class SumOfSines(Protocol):
    """What a move asks of a trajectory class; the attributes are those of `HarmonicClass`."""

    @property
    def terms(self) -> int: ...  # noqa: D102  # as above

    @property
    def amplitude_bound(self) -> Float[ndarray, " joints"]: ...  # noqa: D102  # as above

    @property
    def joints(self) -> int: ...  # noqa: D102  # as above

    @property
    def variables(self) -> Int[ndarray, "joints own"]: ...  # noqa: D102  # as above

    def draw(self, rng: np.random.Generator) -> Float[ndarray, " size"]: ...  # noqa: D102  # as above


def renew_term(
    trajectory: SumOfSines, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """One term with another frequency and amplitude."""
    a, omega = _terms(trajectory, rng)
    z[a[0]] = rng.standard_normal() * trajectory.amplitude_bound.max() / 8
    z[omega[0]] = trajectory.draw(rng)[omega[0]]
    return z


def split_term(
    trajectory: SumOfSines, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """One term's place taken by a part of another, at nearly that one's frequency."""
    a, omega = _terms(trajectory, rng)
    part = rng.standard_normal() * trajectory.amplitude_bound.max() / 4
    z[omega[0]] = z[omega[1]] * np.exp(RELATIVE_SPLIT * rng.standard_normal())
    z[a[0]] = -part
    z[a[1]] += part
    return z


def overtone(
    trajectory: SumOfSines, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """One term turned into an overtone, or undertone, of another."""
    a, omega = _terms(trajectory, rng)
    ratio = rng.choice(OVERTONES)
    z[omega[0]] = ratio * z[omega[1]]
    z[a[0]] = z[a[1]] / ratio**2 * rng.uniform(-OVERTONE_STRENGTH, OVERTONE_STRENGTH)
    return z


def _terms(trajectory: SumOfSines, rng: np.random.Generator) -> tuple[ndarray, ndarray]:
    """Where the amplitudes and frequencies of one joint stand in z, terms in random order."""
    own = trajectory.variables[rng.integers(trajectory.joints)].reshape(2, trajectory.terms)
    a, omega = own[:, rng.permutation(trajectory.terms)]
    return a, omega
