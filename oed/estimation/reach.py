"""Which directions of the parameters the estimation recordings carry to other motions.

A direction that the estimation motion hardly excites is fitted to whatever the model lacks there. Noise
alone does not show it: with many samples its standard deviation is small, and on a motion that excites
the direction the estimate foretells anything. What shows it is how far an error that nobody can see
reaches: one as large as the residual, hidden in the direction, changes the torque of the other motions
by `Reach.factor` times that torque. Beyond 1 the direction is left at zero: the data do not tell it.

Directions are those of the generalised singular value decomposition of both regressors (Golub and Van
Loan, Matrix Computations, 4th ed. 2013, section 6.1.6), so that no unit of a parameter counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.noise import whitened
from oed.estimation.prior import Prior
from oed.estimation.row_pieces import RowPieces
from oed.estimation.triangular import factor_of, triangularise, unit_columns

# An error that equals the whole torque: a prediction of nothing at all is no worse.
LARGEST_REACH = 1.0
# Along what is left at zero a row tells less than one, in units of what is left: a prior that tells a
# hundred times as much leaves a hundredth.
HELD_AT_ZERO = 100.0
# Measured arms leave residuals of 1 % and more; a smaller one is rounding and hides no error.
LEAST_RESIDUAL = 1e-3  # of the torque


@dataclass(frozen=True)
class Reach:
    """How far an unseen error reaches along each of p directions.

    Attributes:
        factor: (p,) rms over samples and joints of the torque that an error as large as the residual
            foretells on the reference motions, over the rms torque; largest first.
        directions: (p, p) column k is direction k in the parameters, scaled to a relative torque of 1.
        coordinates: (p, p) row k gives a parameter vector's coordinate along direction k.
    """

    factor: Float[ndarray, " p"]
    directions: Float[ndarray, "p p"]
    coordinates: Float[ndarray, "p p"]

    @classmethod
    def none(cls, parameters: int) -> Reach:
        """Nothing is hidden, as where a prior tells what the data do not."""
        return cls(np.zeros(parameters), np.eye(parameters), np.eye(parameters))

    @property
    def lost(self) -> int:
        """Number of directions that the estimation motion does not determine."""
        return int(np.sum(self.factor > LARGEST_REACH))

    @property
    def untold(self) -> Float[ndarray, "lost p"]:
        """Each row gives a parameter vector's coordinate along a direction that is not determined."""
        return self.coordinates[: self.lost]

    def prior(self, rows: int) -> Prior:
        """Holds a parameter vector's coordinates along the undetermined directions at zero.

        Args:
            rows: To which it is added, each in units of what is left of its joint.
        """
        return Prior(np.zeros(len(self.factor)), np.sqrt(HELD_AT_ZERO * rows) * self.untold)

    @property
    def spread(self) -> Float[ndarray, " p"]:
        """How far each parameter may be off by an error that hides in the undetermined directions."""
        lost = slice(0, self.lost)
        return np.linalg.norm(self.directions[:, lost] * self.factor[lost], axis=1)


def find_reach(
    fitted: Float[ndarray, "rows p"] | RowPieces,
    others: Sequence[Float[ndarray, "_ p"] | RowPieces],
    residual: Float[ndarray, " joints"],
    torque: Float[ndarray, " joints"],
) -> Reach:
    """Compare what was fitted with the motions that torque is to be foretold for.

    Args:
        fitted: Regressor of the estimation recordings, of full column rank, row k n + j joint j;
            an array, or in pieces.
        others: Regressors of other motions; the reference is the mean of these and the fitted one,
            each as much, however long.
        residual: (n,) rms residual of each joint on the fitted rows [N m].
        torque: (n,) usual torque of each joint, rms [N m].
    """
    joints = len(torque)
    usual = np.maximum(torque, LEAST_RESIDUAL * torque.max(initial=0.0))
    usual = np.where(usual > 0, usual, 1.0)
    error = np.maximum(residual, LEAST_RESIDUAL * usual)
    seen = _mean_factor(fitted, error, joints)
    parts = [_mean_factor(rows, usual, joints) for rows in (fitted, *others)]
    asked, norms = unit_columns(triangularise(np.vstack(parts)) / np.sqrt(len(parts)))
    _, sizes, right = np.linalg.svd(asked)
    sizes = np.maximum(sizes, np.finfo(float).eps * sizes[0])
    to_parameters = (right.T / sizes) / norms[:, None]
    _, strength, turned = np.linalg.svd(seen @ to_parameters)
    # The weakest first.
    strength, turned = strength[::-1], turned[::-1]
    return Reach(
        factor=1 / np.maximum(strength, np.finfo(float).eps),
        directions=to_parameters @ turned.T,
        coordinates=turned @ (sizes[:, None] * right) * norms,
    )


def _mean_factor(
    regressor: Float[ndarray, "rows p"] | RowPieces, unit: Float[ndarray, " joints"], joints: int
) -> Float[ndarray, "p p"]:
    """Triangular factor of the rows, each in its joint's unit, of their mean over samples and joints."""
    pieces = RowPieces.of(regressor, joints)
    return factor_of(whitened(pieces, unit**2)) / np.sqrt(pieces.rows)
