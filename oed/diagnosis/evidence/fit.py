"""Least squares of a model on white rows, kept as a projection: all else asks it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

RANK = 1e-7  # of the largest singular value of normalised columns, below which nothing is excited


@dataclass(frozen=True, eq=False)
class Triangle:
    """Rows of one joint, as far as least squares ask: [X y] = Q R with Q left out.

    Attributes:
        both: (U, k + 1) the joint's white columns that are not zero, and torque.
        factor: (at most k + 1, k + 1) R.
    """

    both: Float[ndarray, "used columns"]
    factor: Float[ndarray, "rank columns"]

    @classmethod
    def of(cls, both: Float[ndarray, "used columns"], before: Triangle | None) -> Triangle:
        """Of white columns and torque; an earlier one serves again where these are as they were."""
        if before is not None and np.array_equal(before.both, both):
            return before
        return cls(both, np.linalg.qr(both, mode="r"))


@dataclass(frozen=True, eq=False)
class Projection:
    """Columns that were fitted to some rows, with priors on some of them.

    Attributes:
        columns: (n, R, p) white columns, all rows.
        used: (R,) rows that were fitted.
        weights: (n,) 1 / sqrt(v) of each joint's rows.
        triangles: Of the used rows, not weighted.
        inverse: (p, b) coefficients = inverse @ basis' y.
        coefficients: (p,) of the torque that was fitted.
        residual: (n, R) white torque less the fit, all rows.
    """

    columns: Float[ndarray, "joints rows columns"]
    used: Bool[ndarray, " rows"]
    weights: Float[ndarray, " joints"]
    triangles: tuple[Triangle, ...]
    inverse: Float[ndarray, "columns rank"]
    coefficients: Float[ndarray, " columns"]
    residual: Float[ndarray, "joints rows"]

    @cached_property
    def basis(self) -> Float[ndarray, "joints used rank"]:
        """Orthonormal with the prior's rows below it, of the used rows."""
        return (self.columns[:, self.used] * self.weights[:, None, None]) @ self.inverse

    @property
    def covariance(self) -> Float[ndarray, "columns columns"]:
        """Of the coefficients, for rows of unit variance in units of v."""
        return self.inverse @ self.inverse.T

    def beyond_others(self, place: slice) -> Float[ndarray, "joints rows"]:
        """What some of the columns give, with their coefficients, that no others could.

        Beside the others X_e is X S_e S_ee^-1, S the covariance of all coefficients.
        """
        S, own = self.covariance, self.coefficients[place]
        sizes = np.linalg.lstsq(S[place, place], own)[0]
        return self.columns @ (S[:, place] @ sizes)

    @cached_property
    def span(self) -> Span:
        """What is asked of the fit again and again, of the rows that were fitted."""
        left = self.residual[:, self.used] * self.weights[:, None]
        return Span(self.basis, left, self.weights)

    def beside(self, columns: dict[int, ndarray]) -> Beside:
        """Further columns beside all of these.

        Args:
            columns: joint -> (R, k) white columns.
        """
        own = {j: c[self.used] * self.weights[j] for j, c in columns.items()}
        left = self.span.left
        return Beside(
            self.span,
            {j: X.T @ X for j, X in own.items()},
            {j: X.T @ left[j] for j, X in own.items()},
            {j: self.basis[j].T @ X for j, X in own.items()},
        )


@dataclass(frozen=True, eq=False)
class Span:
    """An orthonormal basis joint by joint, and what it leaves.

    Attributes:
        basis: (n, U, b) of all joints' weighted rows together.
        left: (n, U) weighted residual.
        weights: (n,) of each joint's white rows.
    """

    basis: Float[ndarray, "joints used rank"]
    left: Float[ndarray, "joints used"]
    weights: Float[ndarray, " joints"]

    @cached_property
    def grams(self) -> Float[ndarray, "joints rank rank"]:
        """Q_j' Q_j."""
        return np.stack([q.T @ q for q in self.basis])

    @cached_property
    def products(self) -> Float[ndarray, "joints rank"]:
        """Q_j' r_j."""
        return np.einsum("jub,ju->jb", self.basis, self.left, optimize=True)

    @cached_property
    def squares(self) -> Float[ndarray, " joints"]:
        """(n,) sums of weighted squares of what is left."""
        return np.sum(self.left**2, axis=1)


@dataclass(frozen=True, eq=False)
class Beside:
    """Further columns beside a span.

    Attributes:
        span: That.
        squares: joint -> (k, k) X_j' X_j of weighted columns.
        scores: joint -> (k,) X_j' r_j.
        inside: joint -> (b, k) Q_j' X_j.
    """

    span: Span
    squares: dict[int, ndarray]
    scores: dict[int, ndarray]
    inside: dict[int, ndarray]

    @cached_property
    def within(self) -> Float[ndarray, "rank columns"]:
        """Q' X of all joints."""
        return np.sum(list(self.inside.values()), axis=0)

    @cached_property
    def information(self) -> Float[ndarray, "columns columns"]:
        """A = X' X less what lies in the span."""
        return np.sum(list(self.squares.values()), axis=0) - self.within.T @ self.within

    @cached_property
    def score(self) -> Float[ndarray, " columns"]:
        """G = X' r."""
        return np.sum(list(self.scores.values()), axis=0)

    def left_by(self, sizes: Float[ndarray, " columns"]) -> Float[ndarray, " joints"]:
        """(n,) sums of squares that are left of white rows with these coefficients, all else refitted."""
        moved = self.within @ sizes
        result = self.span.squares + (2 * self.span.products + self.span.grams @ moved) @ moved
        for j, X in self.squares.items():
            result[j] += sizes @ X @ sizes - 2 * sizes @ self.scores[j]
            result[j] -= 2 * moved @ (self.inside[j] @ sizes)
        return np.maximum(result, 0.0) / self.span.weights**2

    def power(self, sizes: Float[ndarray, " columns"]) -> Float[ndarray, " joints"]:
        """(n,) sums of squares of what the columns give to white rows beyond the span."""
        moved = self.within @ sizes
        result = self.span.grams @ moved @ moved
        for j, X in self.squares.items():
            result[j] += sizes @ X @ sizes - 2 * moved @ (self.inside[j] @ sizes)
        return np.maximum(result, 0.0) / self.span.weights**2


def project(
    torque: Float[ndarray, "joints rows"],
    columns: Float[ndarray, "joints rows columns"],
    used: Bool[ndarray, " rows"],
    variance: Float[ndarray, " joints"],
    precision: Float[ndarray, "columns columns"] | None = None,
    *,
    before: Projection | None = None,
) -> Projection:
    """Fit white columns to white torque, joints weighted by their variance.

    Args:
        torque: White.
        columns: What explains it.
        used: Rows to fit.
        variance: (n,) v of each joint's white rows.
        precision: Of the coefficients' prior; none if None.
        before: Another fit, whose triangles of joints with the same rows serve again; none if None.
    """
    weights, (joints, _, count) = 1 / np.sqrt(variance), columns.shape
    triangles, parts = [], []
    for j in range(joints):
        places = np.flatnonzero(np.any(columns[j], axis=0))
        both = np.concatenate([columns[j][:, places], torque[j][:, None]], axis=1)[used]
        own = Triangle.of(both, None if before is None else before.triangles[j])
        part = np.zeros((len(own.factor), count + 1))
        part[:, [*places, count]] = weights[j] * own.factor
        triangles.append(own)
        parts.append(part)
    if precision is not None and np.any(precision):
        values, vectors = np.linalg.eigh(precision)
        kept = values > 0
        prior = (vectors[:, kept] * np.sqrt(values[kept])).T
        parts.append(np.pad(prior, ((0, 0), (0, 1))))
    stacked = np.concatenate(parts)
    X, y = stacked[:, :-1], stacked[:, -1]
    lengths = np.linalg.norm(X, axis=0)
    lengths = np.where(lengths > 0, lengths, 1.0)
    u, s, vt = np.linalg.svd(X / lengths, full_matrices=False)
    kept = s > RANK * max(float(s.max(initial=0.0)), 1e-300)
    inverse = (vt[kept].T / s[kept]) / lengths[:, None]
    coefficients = inverse @ (u[:, kept].T @ y)
    left = torque - columns @ coefficients
    return Projection(columns, used, weights, tuple(triangles), inverse, coefficients, left)
