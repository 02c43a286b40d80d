"""Least squares in one pass, with memory that does not grow with the samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.least_squares import check_stack
from oed.estimation.noise import TorqueNoise, whiten
from oed.estimation.prior import Prior
from oed.estimation.row_pieces import RowPieces
from oed.estimation.triangular import (
    Solution,
    add_prior,
    augment,
    invert,
    solve,
    triangularise,
)


class StreamingLeastSquares:
    """Takes in blocks of rows and keeps one triangular factor a joint.

    A factor for each joint, rather than one for all, costs n (p + 1)^2 numbers and gives
    two things: the residual of each joint at any parameters, and new joint variances after
    the pass, so that weights can be iterated without reading the data again. It is also
    faster, because the torque of a joint does not depend on most links before it and
    those zero columns are left out.

    QR treats each column on its own scale, so rows need no column scaling on the way in;
    `solve` scales the factor before it judges the rank.
    """

    def __init__(self, parameters: int, joints: int) -> None:
        """Start empty, for p parameters and n joints."""
        if parameters < 1 or joints < 1:
            raise ValueError(f"{parameters=} and {joints=} must be positive")
        self._triangles = np.zeros((joints, parameters + 1, parameters + 1))
        self._rows = 0

    @classmethod
    def of(cls, pieces: RowPieces, torque: Float[ndarray, " rows"]) -> StreamingLeastSquares:
        """What has seen all rows of a regressor and their torque, in one pass.

        Raises:
            ValueError: If an entry is not finite.
        """
        found = cls(pieces.columns, pieces.joints)
        for place, piece in pieces.placed():
            found.add(piece, torque[place])
        return found

    def of_combinations(self, matrix: Float[ndarray, "p q"]) -> StreamingLeastSquares:
        """What has seen the rows times a matrix."""
        found = StreamingLeastSquares(matrix.shape[1], self.joints)
        changed = [np.column_stack([t[:, :-1] @ matrix, t[:, -1]]) for t in self._triangles]
        found._triangles = np.stack([triangularise(t) for t in changed])
        found._rows = self._rows
        return found

    def of_columns(self, kept: Sequence[int]) -> StreamingLeastSquares:
        """What has seen these columns alone."""
        return self.of_combinations(np.eye(self._triangles.shape[1] - 1)[:, list(kept)])

    @property
    def factor(self) -> Float[ndarray, "p p"]:
        """R of all rows seen, unweighted."""
        width = self._triangles.shape[1]
        return triangularise(self._triangles.reshape(-1, width))[:-1, :-1]

    @property
    def rows(self) -> int:
        """Torque equations taken in so far."""
        return self._rows

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self._triangles)

    def add(
        self,
        regressor: Float[ndarray, "rows p"],
        torque: Float[ndarray, " rows"],
        noise: TorqueNoise = None,
    ) -> None:
        """Take in whole samples, sample-major; `noise` as in `whiten`.

        With a full (n, n) noise the joints are mixed by the whitening, and residual sums
        and variances then belong to the whitened channels.

        Raises:
            ValueError: If shapes disagree or an entry is not finite; nothing is then added.
        """
        check_stack(regressor, torque, self.joints)
        width = self._triangles.shape[1]
        if regressor.shape[1] != width - 1:
            raise ValueError(f"{regressor.shape[1]} columns, but {width - 1} parameters")
        if noise is not None:
            regressor = whiten(regressor, noise, self.joints)
            torque = whiten(torque, noise, self.joints)
        updated = [
            _absorb(triangle, regressor[joint :: self.joints], torque[joint :: self.joints])
            for joint, triangle in enumerate(self._triangles)
        ]
        self._triangles = np.stack(updated)
        self._rows += len(torque)

    def squares(self, parameters: Float[ndarray, " p"]) -> Float[ndarray, " joints"]:
        """Residual sum of squares of each joint at any parameters [N^2 m^2]."""
        return np.sum((self._triangles @ np.append(-parameters, 1.0)) ** 2, axis=1)

    def solve(
        self,
        variances: Float[ndarray, " joints"] | None = None,
        prior: Prior | None = None,
    ) -> Solution:
        """Solve for what has been taken in; more may be added afterwards.

        Args:
            variances: (n,) of the joints [N^2 m^2], on top of any noise given to `add`.
            prior: As in `batch_least_squares`.

        Raises:
            ValueError: If a variance is not positive.
            NotIdentifiable: If data and prior together leave a direction undetermined.
        """
        joints, width, _ = self._triangles.shape
        variances = np.ones(joints) if variances is None else variances
        if not np.all(variances > 0):
            raise ValueError("every joint variance must be positive")
        weighted = self._triangles / np.sqrt(variances)[:, None, None]
        data = triangularise(weighted.reshape(joints * width, width))
        posterior = add_prior(data, prior or Prior.flat(width - 1))
        parameters = solve(posterior)
        return Solution(
            parameters=parameters,
            information_factor=data[:-1, :-1],
            posterior_factor=posterior[:-1, :-1],
            squares=self.squares(parameters) / variances,
            rows=self._rows,
        )

    def solve_with_residual_variances(
        self,
        prior: Prior | None = None,
        *,
        tolerance: float = 1e-6,
        iterations: int = 100,
    ) -> tuple[Solution, Float[ndarray, " joints"]]:
        """Solve with joint variances found from the residuals, without another pass.

        Estimate and variances are iterated to a fixed point. Each joint's sum of squares is
        divided by its samples less the parameters that its own rows determine (the trace of
        its block of the hat matrix), so that a joint which determines many is not flattered.

        Returns:
            The solution and the variances (n,) [N^2 m^2].

        Raises:
            ValueError: If a joint has no degree of freedom left.
            NotIdentifiable: If the rows leave a direction undetermined.
        """
        samples = self._rows // self.joints
        least = self._rounding()
        squares = self.squares(self.solve(prior=prior).parameters)
        variances = np.maximum(squares / samples, least)
        for _ in range(iterations):
            solution = self.solve(variances, prior)
            shares = self._parameter_shares(solution, variances)
            before = variances
            squares = self.squares(solution.parameters)
            variances = np.maximum(_unbiased(squares, samples, shares), least)
            if np.all(np.abs(variances - before) <= tolerance * before):
                break
        return self.solve(variances, prior), variances

    def _parameter_shares(
        self, solution: Solution, variances: Float[ndarray, " joints"]
    ) -> Float[ndarray, " joints"]:
        root = invert(solution.posterior_factor)
        influence = self._triangles[:, :-1, :-1] @ root
        return np.sum(influence**2, axis=(1, 2)) / variances

    def _rounding(self) -> Float[ndarray, " joints"]:
        # A joint fitted to rounding would get an infinite weight: rounding of its own torque
        # is the least error that a residual can mean.
        scale = np.sum(self._triangles[:, :, -1] ** 2, axis=1) / (self._rows / self.joints)
        return np.finfo(float).eps ** 2 * np.where(scale > 0, scale, 1.0)


def _unbiased(
    squares: Float[ndarray, " joints"], samples: int, shares: Float[ndarray, " joints"]
) -> Float[ndarray, " joints"]:
    left = samples - shares
    if not np.all(left > 0.5):
        joint = int(np.argmin(left))
        raise ValueError(
            f"joint {joint + 1} has {samples} samples for {shares[joint]:.1f} parameters: "
            "no degree of freedom is left for its variance"
        )
    return squares / left


def _absorb(
    triangle: Float[ndarray, "width width"],
    regressor: Float[ndarray, "samples p"],
    torque: Float[ndarray, " samples"],
) -> Float[ndarray, "width width"]:
    used = np.append(triangle[:, :-1].any(axis=0) | regressor.any(axis=0), True)
    rows = np.asfortranarray(augment(regressor[:, used[:-1]], torque))
    # Zero columns leave zero rows in the factor: the used ones form a triangle of their own.
    before = triangularise(triangle[:, used])
    updated = np.zeros_like(triangle)
    updated[np.ix_(used, used)] = triangularise(np.vstack([before, rows]))
    return updated
