"""The body that can exist next to an estimate of ten parameters.

Nearest in the estimate's own metric: the arm's parameters are taken along by the covariance, so this is
the constrained optimum of the whole problem. What the data leave open is that of a solid ball.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.coordinates import Coordinates
from oed.estimation.feasible.feasible_set import MARGIN, Rows
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.regularisation import Regularisation
from oed.estimation.feasible.solve import FeasibleSolution, solve_problem
from oed.estimation.triangular import augment, triangularise
from oed.robot.inertia import parameters_from_pseudo_inertia

DENSITY = 1000.0  # [kg/m^3] of the ball: grippers and workpieces are metal with hollow spaces
# Of chi squared that a unit of distance to the ball is worth: a determined parameter moves by a
# few hundredths of its standard deviation.
PULL = 0.05
LEAST_MASS = 1e-3  # [kg] of the ball, where the data see no mass


def ball(mass: float, centre: Float[ndarray, "3"]) -> Float[ndarray, "10"]:
    """Ten parameters of a solid ball."""
    pseudo = np.empty((4, 4))
    second = np.outer(centre, centre) + radius_of(mass) ** 2 / 5 * np.eye(3)
    pseudo[:3, :3] = mass * second
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_from_pseudo_inertia(pseudo)


def radius_of(mass: float) -> float:
    """Of the ball [m]."""
    return float((3 * mass / (4 * np.pi * DENSITY)) ** (1 / 3))


def consistent_body(
    parameters: Float[ndarray, " k"],
    covariance: Float[ndarray, "k k"],
    selection: Float[ndarray, "k 10"],
    start: Float[ndarray, "10"],
) -> tuple[Float[ndarray, "10"], FeasibleSolution]:
    """The consistent body nearest to an estimate.

    Args:
        parameters: Of what is determined.
        covariance: Of these.
        selection: Which combinations of the ten parameters they are.
        start: A ball near by, for what is not determined.

    Raises:
        SolverFailed: If no solver came to any point.
    """
    coordinates = Coordinates.relative_to(start, np.zeros(0))
    scale = np.sqrt(np.diag(covariance))
    lower = np.linalg.cholesky(covariance / np.outer(scale, scale))
    whitener = np.linalg.inv(lower) / scale
    triangle = triangularise(
        augment(whitener @ selection @ coordinates.to_parameters, whitener @ parameters)
    )
    none = Rows(np.zeros((0, coordinates.size)), np.zeros(0), ())
    problem = FeasibleProblem(
        coordinates=coordinates,
        factor=triangle[:-1, :-1],
        target=triangle[:-1, -1],
        constant=float(triangle[-1, -1] ** 2),
        rows=1,
        margin=MARGIN,
        inequality=none,
        equality=none,
        regularisation=Regularisation(PULL),
    )
    solution = solve_problem(problem, ("barrier", "clarabel"))
    return coordinates.parameters(solution.x), solution
