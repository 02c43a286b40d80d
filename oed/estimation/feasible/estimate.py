"""The feasible estimate: standard parameters of all links, with what they rest on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.feasible.coordinates import ENTRIES
from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.problem import FeasibleProblem, build_problem
from oed.estimation.feasible.reference import require_consistent, scaled_neutral_bodies
from oed.estimation.feasible.regularisation import Regularisation
from oed.estimation.feasible.solve import FeasibleSolution, SolverName, solve_problem
from oed.robot import Robot
from oed.robot.inertia import pseudo_inertia

# A demand counts as active where giving it up would lower the objective: its price times the
# reference body, per objective.
ACTIVE = 1e-6


@dataclass(frozen=True)
class FeasibleEstimate:
    """Parameters that a simulator accepts.

    Attributes:
        model: Whose parameters these are.
        parameters: (p,) in their units.
        problem: That they solve.
        solution: The proof that they do.
        misfit: Mean squared weighted residual.
        from_data: (p,) share of each value that the data decide, 1 for all and 0 for none; the
            rest is the pull to the reference.
        reference: (10 n,) bodies of that pull.
        has_prior: Whether the reference was given; else it is neutral.
    """

    model: TorqueModel
    parameters: Float[ndarray, " p"]
    problem: FeasibleProblem
    solution: FeasibleSolution
    misfit: float
    from_data: Float[ndarray, " p"]
    reference: Float[ndarray, " inertial"]
    has_prior: bool

    @property
    def names(self) -> tuple[str, ...]:
        """(p,) names of the parameters."""
        return tuple(parameter.name for parameter in self.model.parameters)

    @property
    def units(self) -> tuple[str, ...]:
        """(p,) units of the parameters."""
        return tuple(parameter.unit for parameter in self.model.parameters)

    @property
    def robot(self) -> Robot:
        """The robot with these inertial parameters."""
        return self.model.robot.with_parameters(self.parameters[: ENTRIES * self.model.robot.n])

    @property
    def relative_margins(self) -> Float[ndarray, " links"]:
        """Least eigenvalue of each link's pseudo-inertia relative to its reference body."""
        return self.problem.link_margins(self.solution.x)

    @property
    def margins(self) -> Float[ndarray, " links"]:
        """Least eigenvalue of each link's pseudo-inertia itself [mixed units, SI]."""
        inertial = self.robot.parameters.reshape(-1, ENTRIES)
        return np.array([np.linalg.eigvalsh(pseudo_inertia(link))[0] for link in inertial])

    @property
    def active(self) -> tuple[str, ...]:
        """Demands that hold the estimate where it is: their links' intervals are one-sided."""
        links = zip(self.model.robot.joints, self._active_links, strict=True)
        rows = zip(self.problem.inequality.names, self._active_rows, strict=True)
        return (
            *(f"consistency of {joint.link}" for joint, is_active in links if is_active),
            *(name for name, is_active in rows if is_active),
        )

    @property
    def at_bound(self) -> Bool[ndarray, " p"]:
        """(p,) whether an active demand is on the parameter, or on the link that it is one of."""
        # Unknowns come in the order of the parameters, and mix within a link only.
        held = (self.problem.inequality.matrix[self._active_rows] != 0).any(axis=0)
        inertial = ENTRIES * self.model.robot.n
        links = held[:inertial].reshape(-1, ENTRIES).any(axis=1) | self._active_links
        return np.concatenate([np.repeat(links, ENTRIES), held[inertial:]])

    @property
    def _active_links(self) -> Bool[ndarray, " links"]:
        prices = np.trace(self.solution.multipliers.links, axis1=1, axis2=2) * self.problem.margin
        return (self.relative_margins < 2 * self.problem.margin) & (prices > 0)

    @property
    def _active_rows(self) -> Bool[ndarray, " k"]:
        size = abs(self.solution.objective) * ACTIVE
        is_tight = self.problem.slack(self.solution.x) < ACTIVE
        return (self.solution.multipliers.inequality > size) & is_tight

    def torque(self, motion: Motion) -> Float[ndarray, "samples joints"]:
        """Predicted torque [N m or N]."""
        return self.model.torque(self.parameters, motion)


def estimate_feasible(
    model: TorqueModel,
    data: DataFactor,
    *,
    demands: FeasibleSet | None = None,
    prior: Float[ndarray, " inertial"] | None = None,
    regularisation: Regularisation,
    solvers: Sequence[SolverName] = ("clarabel", "barrier"),
) -> FeasibleEstimate:
    """Least squares over physically consistent parameters.

    Args:
        model: Its first effect is the rigid body.
        data: Factor of the weighted torque equations.
        demands: `FeasibleSet.of(model)` if None.
        prior: (10 n,) CAD or URDF values. Without one, each link is pulled to a rod between
            its joints, all of the one density that explains the data best: what no torque
            depends on is then that of a plain arm of the right weight.
        regularisation: The pull.
        solvers: To try, in this order.

    Raises:
        InfeasiblePrior: If the prior is not physically consistent.
        ContradictoryDemands: If nothing meets all demands.
        SolverFailed: If no solver came to any point that meets them.
    """
    reference = reference_bodies(model, data, prior)
    problem = build_problem(
        model, data, demands or FeasibleSet.of(model), reference, regularisation
    )
    return complete_estimate(
        model, problem, solve_problem(problem, tuple(solvers)), has_prior=prior is not None
    )


def reference_bodies(
    model: TorqueModel, data: DataFactor, prior: Float[ndarray, " inertial"] | None
) -> Float[ndarray, " inertial"]:
    """The prior, or neutral bodies of the density that explains the data best.

    Raises:
        InfeasiblePrior: If the prior is not physically consistent.
    """
    if prior is None:
        return scaled_neutral_bodies(model.robot, data.factor, data.target)
    require_consistent(model.robot, prior)
    return prior


def complete_estimate(
    model: TorqueModel, problem: FeasibleProblem, solution: FeasibleSolution, *, has_prior: bool
) -> FeasibleEstimate:
    """The estimate that a solution stands for."""
    return FeasibleEstimate(
        model=model,
        parameters=problem.coordinates.parameters(solution.x),
        problem=problem,
        solution=solution,
        misfit=problem.misfit(solution.x),
        from_data=share_from_data(problem, solution.x),
        reference=problem.coordinates.reference,
        has_prior=has_prior,
    )


def share_from_data(problem: FeasibleProblem, x: Float[ndarray, " p"]) -> Float[ndarray, " p"]:
    """Diagonal of the resolution matrix H^-1 H_data, in parameters.

    H is the objective's Hessian and H_data that of the misfit: a parameter at 1 moves with the
    data alone, one at 0 stays at its reference (Backus and Gilbert 1968; Menke 2018, ch. 4).
    """
    hessian = problem.hessian(x)
    scale = 1 / np.sqrt(np.diag(hessian))
    data = 2 * problem.factor.T @ problem.factor
    resolution = scale[:, None] * np.linalg.solve(
        hessian * np.outer(scale, scale), scale[:, None] * data
    )
    to_parameters = problem.coordinates.to_parameters
    in_parameters = to_parameters @ np.linalg.solve(to_parameters.T, resolution.T).T
    return np.clip(np.diag(in_parameters), 0.0, 1.0)
