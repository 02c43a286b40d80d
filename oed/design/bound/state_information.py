"""What one state tells about the parameters, and the dual function of the relaxation."""

from __future__ import annotations

from dataclasses import dataclass

import casadi
import numpy as np
import scipy.linalg
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.balance import Monomials
from oed.design.bound.branch_and_bound import Boxes, SmoothFunction
from oed.design.bound.states import ViableStates
from oed.design.bound.weights import WeightedDesign
from oed.design.criteria import whitening
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.torque_model import TorqueModel

FIRST_CELLS = 4  # that branch and bound starts from, along each coordinate; even, to cut at zero


@dataclass(frozen=True)
class StateInformation:
    """What one state tells, for a model: the atoms of the relaxation.

    Attributes:
        model: The torque model; its columns must be affine in the acceleration.
        base: Its base parameters, b of them.
        states: Admissible states.
        functions: Test functions.
        covariance: R_v at one instant, (n,) or (n, n); the identity if None.
    """

    model: TorqueModel
    base: BaseParameters
    states: ViableStates
    functions: Monomials
    covariance: Float[ndarray, "..."] | None = None

    @property
    def white(self) -> Float[ndarray, "joints joints"]:
        """Factor that makes the noise of an instant white."""
        n = self.model.robot.n
        if self.covariance is None:
            return np.eye(n)
        full = np.diag(self.covariance) if self.covariance.ndim == 1 else self.covariance
        return whitening(full)

    def atoms(
        self, x: Float[ndarray, "states coordinates"], ddq: Float[ndarray, "states joints"]
    ) -> tuple[Float[ndarray, "states joints base"], Float[ndarray, "states functions"]]:
        """Regressor rows and rates of the test functions."""
        motion = self.states.motion(x, ddq)
        rows = self.white @ self.base.reduce(self.model.columns(motion))
        return rows, self.functions.rates(motion)

    def dual(self, design: WeightedDesign) -> SmoothFunction:
        """tr(M D' R_v^-1 D) - sum_k y_k d phi_k / dt as a function of the state."""
        n = self.states.joints
        x, ddq = casadi.SX.sym("x", 2 * n), casadi.SX.sym("ddq", n)
        q, v = casadi.SX.sym("q", n), casadi.SX.sym("v", n)
        columns = self.model.symbolic_columns(q, v, ddq, 0.0)
        _require_affine(columns, ddq)
        factor = np.linalg.inv(np.linalg.cholesky(design.information)).T
        reduced = columns[:, self.base.columns.tolist()]
        told = casadi.sumsqr(casadi.DM(self.white) @ reduced @ casadi.DM(factor))
        phi = self.functions.symbolic_sum(design.multipliers, q, v)
        rate = casadi.dot(casadi.gradient(phi, q), v) + casadi.dot(casadi.gradient(phi, v), ddq)
        at_q, at_v = self.states.symbolic(x)
        value = casadi.substitute(told - rate, casadi.vertcat(q, v), casadi.vertcat(at_q, at_v))
        return SmoothFunction.of(value, x, ddq)

    def boxes(self) -> Boxes:
        """The whole set of states, cut at zero velocity, with every vertex of acceleration."""
        edges = []
        for lower, upper in self.states.box:
            cells = np.linspace(lower, upper, FIRST_CELLS + 1)
            edges.append(np.stack([cells[:-1], cells[1:]], axis=1))
        grid = np.meshgrid(*[np.arange(len(e)) for e in edges], indexing="ij")
        cells = np.stack([e[g.ravel()] for e, g in zip(edges, grid, strict=True)], axis=1)
        vertices = self.states.vertices
        middle = np.repeat(cells.mean(axis=2), len(vertices), axis=0)
        half = np.repeat(np.diff(cells, axis=2)[:, :, 0] / 2, len(vertices), axis=0)
        return Boxes(middle, half, np.tile(vertices, (len(cells), 1)))


def dual_values(
    design: WeightedDesign,
    rows: Float[ndarray, "states joints base"],
    rates: Float[ndarray, "states functions"],
) -> Float[ndarray, " states"]:
    """tr(M A) - multipliers . rates of each state."""
    factor = np.linalg.cholesky(design.information)
    flat = scipy.linalg.solve_triangular(factor, rows.reshape(-1, rows.shape[2]).T, lower=True)
    told = (flat**2).sum(axis=0).reshape(rows.shape[:2]).sum(axis=1)
    return told - rates @ design.multipliers


def _require_affine(columns: casadi.SX, ddq: casadi.SX) -> None:
    bend = casadi.jacobian(casadi.vec(casadi.jacobian(casadi.vec(columns), ddq)), ddq)
    if bend.nnz():
        raise ValueError("the bound needs torque columns that are affine in the acceleration")
