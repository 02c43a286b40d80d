"""Generalised least squares of a torque model on whitened rows, kept as a projection.

After one factorisation X = Q R of the whitened regressor, a candidate column c is judged by
what it adds beside the model (Frisch and Waugh): its part outside the span of Q.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.data.direction import reversal_shapes
from oed.diagnosis.fit.model_columns import filtered_columns
from oed.diagnosis.fit.rows import Rows
from oed.dynamics.torque_model import TorqueModel

RANK_TOLERANCE = 1e-7  # of the largest singular value of the normalised regressor
# Share of a candidate's length outside the model below which it is absorbed: what is left is
# smoothing error, and a coefficient that stands on it means nothing.
ABSORBED = 1e-4


@dataclass(frozen=True)
class Projection:
    """An orthonormal basis of a whitened regressor.

    Attributes:
        basis: (n, R, b) blocks of Q, one a joint.
        inverse: (p, b) with parameters = inverse @ Q' y.
    """

    basis: Float[ndarray, "joints rows rank"]
    inverse: Float[ndarray, "parameters rank"]

    def coordinates(self, y: Float[ndarray, "joints rows"]) -> Float[ndarray, " rank"]:
        """Q' y."""
        return np.einsum("jrb,jr->b", self.basis, y, optimize=True)

    def residual(self, y: Float[ndarray, "joints rows"]) -> Float[ndarray, "joints rows"]:
        """Y less its projection."""
        return y - self.basis @ self.coordinates(y)

    def outside(
        self, columns: Float[ndarray, "joints rows columns"]
    ) -> Float[ndarray, "joints rows columns"]:
        """Columns less their projections."""
        return columns - self.basis @ np.einsum("jrb,jrc->bc", self.basis, columns, optimize=True)

    @property
    def rank(self) -> int:
        """Dimension b of the span."""
        return self.basis.shape[2]

    def shares(self) -> Float[ndarray, " joints"]:
        """Parameters that each joint's rows determine; they add up to the rank."""
        return np.einsum("jrb,jrb->j", self.basis, self.basis, optimize=True)


def project(regressor: Float[ndarray, "joints rows parameters"]) -> Projection:
    """Factorise a whitened regressor; directions that the data do not excite are left out."""
    joints, rows, parameters = regressor.shape
    stacked = regressor.reshape(joints * rows, parameters)
    norms = np.linalg.norm(stacked, axis=0)
    norms[norms == 0] = 1.0
    q, r = np.linalg.qr(stacked / norms)
    u, s, vt = np.linalg.svd(r)
    kept = s > RANK_TOLERANCE * s[0]
    basis = q @ u[:, kept]
    inverse = (vt[kept].T / s[kept]) / norms[:, None]
    return Projection(basis.reshape(joints, rows, -1), inverse)


@dataclass(frozen=True)
class LinearFit:
    """A model fitted to whitened rows.

    Attributes:
        model: The torque model, shapes fixed.
        columns: (b,) indices of the model's columns that are estimated; additions follow them.
        rows: What it is fitted to.
        projection: Of its whitened regressor.
        parameters: (p,) estimates of these columns, then of the additions'.
        residual: (n, R) white residual.
    """

    model: TorqueModel
    columns: Int[ndarray, " base"]
    rows: Rows
    projection: Projection
    parameters: Float[ndarray, " parameters"]
    residual: Float[ndarray, "joints rows"]

    @property
    def squares(self) -> float:
        """Sum of squared white residuals: -2 log likelihood but for a constant."""
        return float(np.sum(self.residual**2))

    def freedom(self) -> Float[ndarray, " joints"]:
        """(n,) rows of each joint that count, less its share of the fitted columns; at least one."""
        rows = np.sum(self.rows.weights**2, axis=0)
        return np.maximum(rows - self.projection.shares(), 1.0)

    def full_parameters(self) -> Float[ndarray, " all_parameters"]:
        """Parameters of every column of the model, regrouped ones at zero."""
        full = np.zeros(len(self.model.parameters))
        full[self.columns] = self.parameters[: len(self.columns)]
        return full

    def covariance(self) -> Float[ndarray, "parameters parameters"]:
        """Covariance of the estimates, unit noise."""
        return self.projection.inverse @ self.projection.inverse.T


def whitened_regressor(
    model: TorqueModel, columns: Int[ndarray, " parameters"], rows: Rows
) -> Float[ndarray, "joints rows parameters"]:
    """White columns of a model, joint by joint."""
    filtered = [filtered_columns(model, p, columns) for p in rows.prepared]
    joints = model.robot.n
    return np.stack([rows.whiten([f[:, j] for f in filtered], j) for j in range(joints)])


def reversal_nuisances(rows: Rows) -> Float[ndarray, "joints rows nuisances"]:
    """White columns for what no log resolves at a reversal: its exact time, and its sharpness.

    An impulse at every reversal takes up a mean error of its timing, a narrow bump that
    changes sign takes up a step less sharp or sharper than the model's. They are fitted beside
    every model, belong to none, and are left out of every prediction.
    """
    joints = rows.weights.shape[1]
    result = np.zeros((joints, rows.count, 2 * joints))
    for j in range(joints):
        fine = [reversal_shapes(p, j) for p in rows.prepared]
        result[j, :, 2 * j : 2 * j + 2] = rows.whiten_fine(fine, j)
    return result


def fit_model(
    model: TorqueModel,
    columns: Int[ndarray, " parameters"],
    rows: Rows,
    known: Sequence[Float[ndarray, "_ joints"]] | None = None,
) -> LinearFit:
    """Fit the chosen columns of a model, and the rows' nuisances, to whitened rows.

    Args:
        model: The torque model, shapes fixed.
        columns: (b,) indices of the model's columns to estimate.
        rows: What to fit.
        known: Torque on the fine grid that is not the model's, one array a recording [N m].
    """
    regressor = whitened_regressor(model, columns, rows)
    torque = rows.torque()
    if known is not None:
        torque -= np.stack(
            [rows.whiten_fine([k[:, [j]] for k in known], j)[:, 0] for j in range(len(torque))]
        )
    everything = np.concatenate([regressor, reversal_nuisances(rows)], axis=2)
    projection = project(everything)
    coordinates = projection.coordinates(torque)
    projection = Projection(projection.basis, projection.inverse[: regressor.shape[2]])
    return LinearFit(
        model=model,
        columns=columns,
        rows=rows,
        projection=projection,
        parameters=projection.inverse @ coordinates,
        residual=torque - projection.basis @ coordinates,
    )


@dataclass(frozen=True)
class Addition:
    """What a group of columns adds to a fit.

    Attributes:
        gain: Fall of the sum of squares.
        coefficients: (m,) of the group's columns.
        rank: Columns that are not absorbed by the model.
        variance: (m,) of the coefficients, unit noise.
    """

    gain: float
    coefficients: Float[ndarray, " columns"]
    rank: int
    variance: Float[ndarray, " columns"]


def addition(
    projection: Projection,
    residual: Float[ndarray, "joints rows"],
    group: Mapping[int, Float[ndarray, "rows columns"]],
    ridge: float = 0.0,
) -> Addition:
    """Gain of a group of white columns beside a model.

    Args:
        projection: Of the model.
        residual: White residual of the model.
        group: White columns for each joint that they act on.
        ridge: Added to the Gram matrix of unit columns.
    """
    gram, moment = gram_and_moment(projection, residual, group)
    return solve_addition(*gram, moment, ridge)


def gram_and_moment(
    projection: Projection,
    residual: Float[ndarray, "joints rows"],
    group: Mapping[int, Float[ndarray, "rows columns"]],
) -> tuple[
    tuple[Float[ndarray, "columns columns"], Float[ndarray, " columns"]], Float[ndarray, " columns"]
]:
    """Gram matrix of the group outside the model, its columns' whole squared lengths, moments."""
    columns = next(iter(group.values())).shape[1]
    gram = np.zeros((columns, columns))
    moment = np.zeros(columns)
    inside = np.zeros((projection.rank, columns))
    for joint, block in group.items():
        gram += block.T @ block
        moment += block.T @ residual[joint]
        inside += projection.basis[joint].T @ block
    lengths = np.diag(gram).copy()
    return (gram - inside.T @ inside, lengths), moment


def solve_addition(
    gram: Float[ndarray, "columns columns"],
    lengths: Float[ndarray, " columns"],
    moment: Float[ndarray, " columns"],
    ridge: float = 0.0,
) -> Addition:
    """Gain and coefficients from the normal equations of the part outside the model."""
    scale = np.sqrt(np.where(lengths > 0, lengths, 1.0))
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    kept = values > ABSORBED**2 * len(values)
    if not kept.any():
        zero = np.zeros(len(lengths))
        return Addition(0.0, zero, 0, zero)
    turned = vectors[:, kept]
    projected = turned.T @ (moment / scale)
    inverse = 1 / (values[kept] + ridge)
    coefficients = turned @ (inverse * projected) / scale
    gain = float(np.sum(projected**2 * inverse))
    variance = np.sum(turned**2 * inverse, axis=1) / scale**2
    return Addition(gain, coefficients, int(kept.sum()), variance)
