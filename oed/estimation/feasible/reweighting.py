"""A feasible estimate with the joints' torque variances as they are left by itself.

Plain least squares may explain joints by parameters that no robot has; its residuals are then
smaller than any robot's, and weights made of them give such joints all the say. Here the
variances are those of the feasible estimate's own residuals: with the concentrated likelihood, the
sum over joints of N log(rms residual), falling at each solve (Seber and Wild 1989, "Nonlinear
Regression", section 11.2; iterated Aitken estimator).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.data_factor import JointFactors
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.solve import FeasibleSolution, SolverName, solve_problem

# Variances are settled to a per cent or two after the third solve on every measured arm.
SOLVES = 3


@dataclass(frozen=True)
class ReweightedFit:
    """The last solve and its weights.

    Attributes:
        problem: With the data weighted by `variances`.
        solution: Of that problem.
        variances: (n,) torque variance of each joint [N^2 m^2] that the data are weighted by.
    """

    problem: FeasibleProblem
    solution: FeasibleSolution
    variances: Float[ndarray, " joints"]

    @property
    def parameters(self) -> Float[ndarray, " p"]:
        """In their units."""
        return self.problem.coordinates.parameters(self.solution.x)


def solve_reweighted(
    problem: FeasibleProblem,
    data: JointFactors,
    variances: Float[ndarray, " joints"],
    *,
    solvers: tuple[SolverName, ...] = ("clarabel", "barrier"),
    solves: int = SOLVES,
) -> ReweightedFit:
    """Solve, take each joint's variance from the residuals, and solve again.

    Args:
        problem: Its demands, reference and pull are kept.
        data: To be fitted.
        variances: To begin with.
        solvers: To try, in this order.
        solves: In all.

    Raises:
        ContradictoryDemands: If nothing meets all demands.
        SolverFailed: If no solver came to any point.
    """
    fit = _weighted_fit(problem, data, variances, solvers)
    for _ in range(solves - 1):
        fit = _weighted_fit(problem, data, data.variances(fit.parameters), solvers)
    return fit


def _weighted_fit(
    problem: FeasibleProblem,
    data: JointFactors,
    variances: Float[ndarray, " joints"],
    solvers: tuple[SolverName, ...],
) -> ReweightedFit:
    weighted = problem.with_data(data.weighted(variances))
    return ReweightedFit(weighted, solve_problem(weighted, solvers), variances)


def log_rms(
    data: JointFactors,
    parameters: Float[ndarray, " p"],
    unit: Float[ndarray, " joints"],
) -> float:
    """Mean over joints of log(rms residual / unit): minus the concentrated log-likelihood a sample.

    It needs no weights, and an error of a tenth counts the same at every joint.

    Args:
        data: To be predicted.
        parameters: In their units.
        unit: (n,) squared, of each joint [N^2 m^2].
    """
    return float(0.5 * np.mean(np.log(data.variances(parameters) / unit)))
