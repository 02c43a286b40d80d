"""Generalised least squares of a torque model on whitened rows, kept as a factorisation.

After one factorisation X = Q R of the whitened regressor, whatever is asked of the fit is a
product with Q.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.effects import Effect, State
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.noise_floor.weighted_rows import Rows
from oed.experiment.preparation.direction import reversal_shapes
from oed.experiment.preparation.prepared import Prepared

RANK_TOLERANCE = 1e-7  # of the largest singular value of the normalised regressor
NUISANCES = 2  # columns a joint that are fitted beside every model


@dataclass(frozen=True)
class Factorisation:
    """An orthonormal basis of a whitened regressor.

    Attributes:
        basis: (n, R, b) blocks of Q, one a joint.
        inverse: (p, b) with parameters = inverse @ Q' y.
    """

    basis: Float[ndarray, "joints rows rank"]
    inverse: Float[ndarray, "parameters rank"]

    def coordinates(self, y: Float[ndarray, "joints rows"]) -> Float[ndarray, " rank"]:
        """Q' y."""
        return _flat(self.basis).T @ y.ravel()

    def residual(self, y: Float[ndarray, "joints rows"]) -> Float[ndarray, "joints rows"]:
        """Y less its projection."""
        return y - self.basis @ self.coordinates(y)

    def outside(
        self, columns: Float[ndarray, "joints rows columns"]
    ) -> Float[ndarray, "joints rows columns"]:
        """Columns less their projections."""
        return columns - self.basis @ self._inside(columns)

    def _inside(
        self, columns: Float[ndarray, "joints rows columns"]
    ) -> Float[ndarray, "rank columns"]:
        return _flat(self.basis).T @ _flat(columns)

    @property
    def rank(self) -> int:
        """Dimension b of the span."""
        return self.basis.shape[2]

    def shares(self) -> Float[ndarray, " joints"]:
        """Parameters that each joint's rows determine; they add up to the rank."""
        return np.einsum("jrb,jrb->j", self.basis, self.basis, optimize=True)


def _flat(columns: Float[ndarray, "joints rows columns"]) -> Float[ndarray, "all_rows columns"]:
    joints, rows, count = columns.shape  # -1 would not do for no columns
    return columns.reshape(joints * rows, count)


def factorise(regressor: Float[ndarray, "joints rows parameters"]) -> Factorisation:
    """Factorise a whitened regressor; directions that the data do not excite are left out."""
    joints, rows, count = regressor.shape
    lengths = np.sqrt(np.einsum("jrp,jrp->p", regressor, regressor, optimize=True))
    lengths = np.where(lengths > 0, lengths, 1.0)
    q, r = np.linalg.qr(regressor.reshape(joints * rows, count) / lengths)
    u, s, vt = np.linalg.svd(r, full_matrices=False)
    kept = s > RANK_TOLERANCE * max(s.max(initial=0.0), 1.0)
    basis = q @ u[:, kept]
    return Factorisation(basis.reshape(joints, rows, -1), (vt[kept].T / s[kept]) / lengths[:, None])


@dataclass(frozen=True)
class LinearFit:
    """A model fitted to whitened rows.

    Attributes:
        model: The torque model, shapes fixed.
        columns: (b,) indices of the model's columns that are estimated.
        rows: What it is fitted to.
        factorisation: Of its whitened regressor.
        parameters: (p,) estimates of these columns.
        residual: (n, R) white residual.
    """

    model: TorqueModel
    columns: Int[ndarray, " base"]
    rows: Rows
    factorisation: Factorisation
    parameters: Float[ndarray, " parameters"]
    residual: Float[ndarray, "joints rows"]

    @property
    def squares(self) -> float:
        """Sum of squared white residuals: -2 log likelihood but for a constant."""
        return float(np.sum(self.residual**2))

    def freedom(self) -> Float[ndarray, " joints"]:
        """(n,) rows of each joint that count, less its share of the fitted columns; at least one."""
        return np.maximum(self.rows.counted - self.factorisation.shares(), 1.0)

    def full_parameters(self) -> Float[ndarray, " all_parameters"]:
        """Parameters of every column of the model, regrouped ones at zero."""
        full = np.zeros(len(self.model.parameters))
        full[self.columns] = self.parameters[: len(self.columns)]
        return full

    def covariance(self) -> Float[ndarray, "parameters parameters"]:
        """Covariance of the estimates, unit noise."""
        return self.factorisation.inverse @ self.factorisation.inverse.T


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
    result = np.zeros((joints, rows.count, NUISANCES * joints))
    for j in range(joints):
        fine = [reversal_shapes(p, j) for p in rows.prepared]
        result[j, :, NUISANCES * j : NUISANCES * (j + 1)] = rows.whiten_fine(fine, j)
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
    torque = rows.torque()
    if known is not None:
        torque -= np.stack(
            [rows.whiten_fine([k[:, [j]] for k in known], j)[:, 0] for j in range(len(torque))]
        )
    return fit_span(model, columns, rows, span_of_model(model, columns, rows), torque)


def span_of_model(model: TorqueModel, columns: Int[ndarray, " base"], rows: Rows) -> Factorisation:
    """The chosen white columns of a model, and after them the nuisances."""
    return factorise(
        np.concatenate([whitened_regressor(model, columns, rows), reversal_nuisances(rows)], axis=2)
    )


def fit_span(
    model: TorqueModel,
    columns: Int[ndarray, " base"],
    rows: Rows,
    span: Factorisation,
    torque: Float[ndarray, "joints rows"],
) -> LinearFit:
    """Fit white columns to white torque.

    Args:
        model: Whose columns come first in the span.
        columns: (b,) indices of these.
        rows: White rows.
        span: Of the model's columns, the nuisances, and additions.
        torque: What they are to explain.
    """
    coordinates = span.coordinates(torque)
    nuisances = slice(len(columns), len(columns) + NUISANCES * len(torque))
    asked = np.delete(span.inverse, nuisances, axis=0)
    return LinearFit(
        model=model,
        columns=columns,
        rows=rows,
        factorisation=Factorisation(span.basis, asked),
        parameters=asked @ coordinates,
        residual=torque - span.basis @ coordinates,
    )


def filtered_columns(
    model: TorqueModel, prepared: Prepared, columns: Int[ndarray, " kept"]
) -> Float[ndarray, "rows joints kept"]:
    """The chosen columns of a model in the analysis band."""
    fine = model.columns(prepared.motion)[:, :, columns]
    return prepared.band.apply(fine)


def effect_columns(
    effect: Effect, motion: Motion, sign_width: float
) -> dict[int, Float[ndarray, "samples columns"]]:
    """Columns of one effect on the fine grid, for the joints that it acts on."""
    state = State.along(motion, sign_width)
    entries = effect.entries(state)
    acting = sorted({joint for entry in entries for joint in entry})
    result = {}
    for joint in acting:
        rows = np.empty((len(entries), len(motion)))
        for row, entry in zip(rows, entries, strict=True):
            row[:] = entry.get(joint, 0.0)
        result[joint] = rows.T
    return result
