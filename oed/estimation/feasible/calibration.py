"""From a calibration by plain least squares to a feasible one, with all that is asked of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.torque_model import TorqueModel
from oed.estimation.calibration import Calibration
from oed.estimation.feasible.base_feasibility import BaseFeasibility, base_feasibility
from oed.estimation.feasible.bootstrap import Bootstrap, bootstrap
from oed.estimation.feasible.cross_validation import FOLDS, WEIGHTS, WeightCurve, cross_validate
from oed.estimation.feasible.data_factor import DataFactor, block_factors
from oed.estimation.feasible.estimate import (
    FeasibleEstimate,
    complete_estimate,
    estimate_feasible,
)
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.mass_matrix import (
    mass_matrices,
    random_poses,
    share_positive_definite,
)
from oed.estimation.feasible.regularisation import Regularisation, RegularisationKind
from oed.estimation.feasible.solve import FeasibleSolution, SolverName, solve_problem
from oed.estimation.validation import Validation, validate
from oed.experiment.processing import ProcessedRecording
from oed.experiment.recording import Role


@dataclass(frozen=True)
class FeasibleSettings:
    """How a feasible calibration is made.

    Attributes:
        demands: On the parameters; `FeasibleSet.of(model)` if None.
        prior: (10 n,) CAD or URDF values to be pulled to; None for neutral bodies.
        kind: Of the pull.
        weight: Of the pull; by cross-validation if None.
        weights: Tried in cross-validation.
        folds: Of the cross-validation.
        blocks: Pieces that the data are cut into, for folds and bootstrap.
        resamples: Of the bootstrap.
        poses: At which mass matrices are examined.
        seed: Of poses and bootstrap.
    """

    demands: FeasibleSet | None = None
    prior: Float[ndarray, " inertial"] | None = None
    kind: RegularisationKind = "entropic"
    weight: float | None = None
    weights: tuple[float, ...] = field(default=WEIGHTS)
    folds: int = FOLDS
    blocks: int = 20
    resamples: int = 60
    poses: int = 10_000
    seed: int = 0


@dataclass(frozen=True)
class FeasibleCalibration:
    """A feasible estimate beside the plain one.

    Attributes:
        plain: Least squares of the base parameters, and the data.
        plain_parameters: (p,) its estimate with all regrouped parameters zero.
        estimate: The feasible one.
        curve: By which its weight was chosen; None where it was given.
        second: The same problem by the other solver; None where that failed.
        second_failure: Why it failed, empty if it did not.
        bootstrap: Of the feasible estimate.
        validation: By role, how well the feasible estimate predicts.
        plain_feasibility: Whether any feasible robot is behind the plain estimate.
        positive_definite: Share of poses with a positive definite mass matrix.
        plain_positive_definite: The same of the plain estimate.
        settings: It was made with.
    """

    plain: Calibration
    plain_parameters: Float[ndarray, " p"]
    estimate: FeasibleEstimate
    curve: WeightCurve | None
    second: FeasibleSolution | None
    second_failure: str
    bootstrap: Bootstrap
    validation: Mapping[Role, Validation]
    plain_feasibility: BaseFeasibility
    positive_definite: float
    plain_positive_definite: float
    settings: FeasibleSettings

    @property
    def disagreement(self) -> float | None:
        """Relative difference of the objective between the two solvers."""
        if self.second is None:
            return None
        value = self.estimate.solution.objective
        return abs(value - self.second.objective) / abs(value)

    def price(self, role: Role) -> float:
        """Relative rise of the overall rms residual against plain least squares."""
        return self.validation[role].overall_rms / self.plain.validation[role].overall_rms - 1.0


def calibrate_feasibly(plain: Calibration, settings: FeasibleSettings) -> FeasibleCalibration:
    """Estimate feasible parameters from the data of a plain calibration.

    Args:
        plain: Its model, recordings and joint variances are used.
        settings: How.

    Raises:
        InfeasiblePrior: If the prior is not physically consistent.
        ContradictoryDemands: If nothing meets all demands.
        SolverFailed: If no solver's solution passes its check.
    """
    model = plain.model
    blocks = block_factors(
        model,
        plain.recordings["estimation"],
        plain.estimate.joint_variances,
        blocks=settings.blocks,
    )
    estimate, curve = _estimate(model, blocks, settings)
    second, failure = _second_opinion(estimate)
    rng = np.random.default_rng(settings.seed)
    q = random_poses(model, settings.poses, rng)
    base_values = np.zeros(len(plain.base))
    base_values[list(plain.estimate.columns)] = plain.estimate.parameters
    plain_parameters = plain.base.to_standard(base_values)
    return FeasibleCalibration(
        plain=plain,
        plain_parameters=plain_parameters,
        estimate=estimate,
        curve=curve,
        second=second,
        second_failure=failure,
        bootstrap=bootstrap(estimate, blocks, rng, resamples=settings.resamples),
        validation={
            role: validate_parameters(model, estimate.parameters, recordings)
            for role, recordings in plain.recordings.items()
        },
        plain_feasibility=base_feasibility(
            model, plain.base, base_values, demands=settings.demands, reference=estimate.reference
        ),
        positive_definite=share_positive_definite(mass_matrices(model, estimate.parameters, q)),
        plain_positive_definite=share_positive_definite(mass_matrices(model, plain_parameters, q)),
        settings=settings,
    )


def validate_parameters(
    model: TorqueModel,
    parameters: Float[ndarray, " p"],
    recordings: tuple[ProcessedRecording, ...],
) -> Validation:
    """How well full parameters predict the torque of recordings."""
    predicted = [recording.columns(model.columns) @ parameters for recording in recordings]
    measured = [recording.tau for recording in recordings]
    return validate(np.concatenate(predicted), np.concatenate(measured))


def _estimate(
    model: TorqueModel, blocks: tuple[DataFactor, ...], settings: FeasibleSettings
) -> tuple[FeasibleEstimate, WeightCurve | None]:
    first = settings.weight or settings.weights[0]
    estimate = estimate_feasible(
        model,
        DataFactor.join(blocks),
        demands=settings.demands,
        prior=settings.prior,
        regularisation=Regularisation(first, settings.kind),
    )
    if settings.weight is not None:
        return estimate, None
    curve = cross_validate(estimate.problem, blocks, weights=settings.weights, folds=settings.folds)
    problem = estimate.problem.with_weight(curve.weight)
    return (
        complete_estimate(model, problem, solve_problem(problem), has_prior=estimate.has_prior),
        curve,
    )


def _second_opinion(estimate: FeasibleEstimate) -> tuple[FeasibleSolution | None, str]:
    other: SolverName = "barrier" if estimate.solution.solver == "clarabel" else "clarabel"
    try:
        return solve_problem(estimate.problem, (other,)), ""
    except SolverFailed as failure:
        return None, "; ".join(failure.attempts) or str(failure)
