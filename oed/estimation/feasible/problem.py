"""The convex problem, once, in plain arrays: what every solver and every check is given."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.torque_model import TorqueModel
from oed.estimation.feasible.coordinates import ENTRIES, Coordinates
from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.feasible_set import (
    FeasibleSet,
    Rows,
    equality_rows,
    inequality_rows,
)
from oed.estimation.feasible.regularisation import Regularisation

# Pull on the effects' parameters, so that those which the data cannot tell apart have a value:
# far below what moves a residual.
TIE_BREAK = 1e-10
# Share of the mean squared torque below which an objective is rounding: without noise it is
# zero, and no error is small relative to that.
ROUNDING = 1e-8


@dataclass(frozen=True)
class FeasibleProblem:
    """min |A x - b|^2 + c + weight * distance(x) over feasible x.

    Attributes:
        coordinates: Of the unknowns x.
        factor: (p, p) A, triangular factor of the weighted data per square root of the rows.
        target: (p,) b.
        constant: c, the part of the mean squared residual that no parameter changes.
        rows: Torque equations that went in.
        margin: J^_i >= margin I for every link.
        inequality: Rows C x >= d, each of unit length.
        equality: Rows C x = d, each of unit length.
        regularisation: Pull to the reference.
    """

    coordinates: Coordinates
    factor: Float[ndarray, "p p"]
    target: Float[ndarray, " p"]
    constant: float
    rows: int
    margin: float
    inequality: Rows
    equality: Rows
    regularisation: Regularisation

    @property
    def tie_break(self) -> Float[ndarray, " p"]:
        """Second derivative of the pull on each unknown that keeps effects determined."""
        pull = np.full(self.coordinates.size, TIE_BREAK)
        pull[: ENTRIES * self.coordinates.links] = 0.0
        return pull

    def misfit(self, x: Float[ndarray, " p"]) -> float:
        """Mean squared weighted residual."""
        return float(np.sum((self.factor @ x - self.target) ** 2) + self.constant)

    def objective(self, x: Float[ndarray, " p"]) -> float:
        """What is minimised."""
        pull = 0.5 * float(np.sum(self.tie_break * x**2))
        distance = self.regularisation.value(self.coordinates, x)
        return self.misfit(x) + pull + self.regularisation.weight * distance

    def size(self, x: Float[ndarray, " p"]) -> float:
        """What an error of the objective is relative to."""
        return self.objective(x) + ROUNDING * float(np.sum(self.target**2) + self.constant)

    def gradient(self, x: Float[ndarray, " p"]) -> Float[ndarray, " p"]:
        """Gradient of the objective."""
        data = 2 * self.factor.T @ (self.factor @ x - self.target)
        distance = self.regularisation.gradient(self.coordinates, x)
        return data + self.tie_break * x + self.regularisation.weight * distance

    def hessian(self, x: Float[ndarray, " p"]) -> Float[ndarray, "p p"]:
        """Second derivatives of the objective."""
        data = 2 * self.factor.T @ self.factor
        distance = self.regularisation.hessian(self.coordinates, x)
        return data + np.diag(self.tie_break) + self.regularisation.weight * distance

    def slack(self, x: Float[ndarray, " p"]) -> Float[ndarray, " k"]:
        """By how much each inequality row is exceeded."""
        return self.inequality.matrix @ x - self.inequality.bound

    def link_margins(self, x: Float[ndarray, " p"]) -> Float[ndarray, " links"]:
        """Least eigenvalue of each J^_i."""
        return np.linalg.eigvalsh(self.coordinates.relative_inertias(x))[:, 0]

    def with_weight(self, weight: float) -> FeasibleProblem:
        """This problem with another pull to the reference."""
        regularisation = dataclasses.replace(self.regularisation, weight=weight)
        return dataclasses.replace(self, regularisation=regularisation)

    def with_data(self, data: DataFactor) -> FeasibleProblem:
        """This problem for other data."""
        factor, target, constant = _in_unknowns(data, self.coordinates)
        return dataclasses.replace(
            self, factor=factor, target=target, constant=constant, rows=data.rows
        )


def build_problem(
    model: TorqueModel,
    data: DataFactor,
    demands: FeasibleSet,
    reference: Float[ndarray, " inertial"],
    regularisation: Regularisation,
) -> FeasibleProblem:
    """Put data and demands into unknowns of size one.

    Args:
        model: Its first effect is the rigid body.
        data: Factor of the weighted torque equations of `model`.
        demands: On the parameters.
        reference: (10 n,) bodies to be pulled to, and to measure margins against.
        regularisation: The pull.

    Raises:
        ValueError: If model, data and reference differ in size.
    """
    count, inertial = len(model.parameters), ENTRIES * model.robot.n
    if len(data.target) != count or len(reference) != inertial:
        raise ValueError(
            f"the model has {count} parameters, {inertial} of them inertial; the data "
            f"{len(data.target)}, the reference {len(reference)}"
        )
    # One scale of an effect makes a weighted torque of about one.
    norms = np.linalg.norm(data.factor[:, inertial:], axis=0) / np.sqrt(data.rows)
    scales = 1 / np.where(norms > 0, norms, 1.0)
    coordinates = Coordinates.relative_to(reference, scales)
    factor, target, constant = _in_unknowns(data, coordinates)
    return FeasibleProblem(
        coordinates=coordinates,
        factor=factor,
        target=target,
        constant=constant,
        rows=data.rows,
        margin=demands.margin,
        inequality=_unit_rows(inequality_rows(demands, model), coordinates),
        equality=_unit_rows(equality_rows(demands, model), coordinates),
        regularisation=regularisation,
    )


def _in_unknowns(
    data: DataFactor, coordinates: Coordinates
) -> tuple[Float[ndarray, "p p"], Float[ndarray, " p"], float]:
    root = np.sqrt(data.rows)
    return (
        data.factor @ coordinates.to_parameters / root,
        data.target / root,
        data.remainder**2 / data.rows,
    )


def _unit_rows(rows: Rows, coordinates: Coordinates) -> Rows:
    matrix = rows.matrix @ coordinates.to_parameters
    lengths = np.linalg.norm(matrix, axis=1)
    return Rows(matrix / lengths[:, None], rows.bound / lengths, rows.names)
