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
from oed.estimation.feasible.change_from_file import LinkChange, link_changes
from oed.estimation.feasible.cross_validation import FOLDS, WEIGHTS, WeightCurve, cross_validate
from oed.estimation.feasible.data_factor import JointFactors, block_factors
from oed.estimation.feasible.estimate import (
    FeasibleEstimate,
    complete_estimate,
    reference_bodies,
)
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.mass_matrix import (
    mass_matrices,
    random_poses,
    share_positive_definite,
)
from oed.estimation.feasible.problem import build_problem
from oed.estimation.feasible.reference import FileInertials, file_inertials
from oed.estimation.feasible.regularisation import Regularisation, RegularisationKind
from oed.estimation.feasible.reweighting import solve_reweighted
from oed.estimation.feasible.solve import FeasibleSolution, SolverName, solve_problem
from oed.estimation.validation import Validation, validate
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import Role


@dataclass(frozen=True)
class FeasibleSettings:
    """How a feasible calibration is made.

    Attributes:
        demands: On the parameters; `FeasibleSet.of(model)` if None.
        inertials: Of the robot's file, as a prior and to be compared with; those that
            `file_inertials` takes if None.
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
    inertials: FileInertials | None = None
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
        estimate: The feasible one.
        curve: By which its weight was chosen; None where it was given.
        second: The same problem by the other solver; None where that failed.
        second_failure: Why it failed, empty if it did not.
        joint_variances: (n,) torque variances that the data are weighted by, of the feasible
            estimate's own residuals [N^2 m^2].
        inertials: What was made of the robot file's.
        changes: Of each link and of the total mass; empty where the file's are placeholders.
        bootstrap: Of the feasible estimate.
        validation: By role, how well the feasible estimate predicts.
        plain_feasibility: Whether any feasible robot is behind the plain estimate; None where
            that was not found out.
        plain_feasibility_failure: Why not, empty if it was.
        positive_definite: Share of poses with a positive definite mass matrix.
        plain_positive_definite: The same of the plain estimate.
        settings: It was made with.
    """

    plain: Calibration
    estimate: FeasibleEstimate
    curve: WeightCurve | None
    second: FeasibleSolution | None
    second_failure: str
    joint_variances: Float[ndarray, " joints"]
    inertials: FileInertials
    changes: tuple[LinkChange, ...]
    bootstrap: Bootstrap
    validation: Mapping[Role, Validation]
    plain_feasibility: BaseFeasibility | None
    plain_feasibility_failure: str
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

    @property
    def warnings(self) -> tuple[str, ...]:
        """What of the estimate is not to be believed, in words."""
        solution = self.estimate.solution
        unsolved = () if self.curve is None else self.curve.unsolved
        return (
            *(() if solution.is_accurate else (f"accuracy: {solution.accuracy}",)),
            *(
                f"weight {weight:.0e} was passed over: no solver came to a solution in every fold"
                for weight in unsolved
            ),
            *(change.warning for change in self.changes if change.warning),
        )

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
        SolverFailed: If no solver came to any point that meets them.
    """
    model = plain.model
    inertials = settings.inertials or file_inertials(model.robot)
    blocks = block_factors(model, plain.recordings["estimation"], blocks=settings.blocks)
    estimate, curve, variances = _estimate(plain, blocks, settings, inertials.prior)
    second, failure = _second_opinion(estimate)
    rng = np.random.default_rng(settings.seed)
    q = random_poses(model, settings.poses, rng)
    base_values = np.zeros(len(plain.base))
    base_values[list(plain.estimate.columns)] = plain.estimate.parameters
    feasibility, unanswered = _base_feasibility(plain, base_values, estimate, settings.demands)
    weighted = [block.weighted(variances) for block in blocks]
    spread = bootstrap(estimate, weighted, rng, resamples=settings.resamples)
    return FeasibleCalibration(
        plain=plain,
        estimate=estimate,
        curve=curve,
        second=second,
        second_failure=failure,
        joint_variances=variances,
        inertials=inertials,
        changes=_changes(estimate, inertials, spread),
        bootstrap=spread,
        validation={
            role: validate_parameters(model, estimate.parameters, recordings)
            for role, recordings in plain.recordings.items()
        },
        plain_feasibility=feasibility,
        plain_feasibility_failure=unanswered,
        positive_definite=share_positive_definite(mass_matrices(model, estimate.parameters, q)),
        plain_positive_definite=share_positive_definite(mass_matrices(model, plain.parameters, q)),
        settings=settings,
    )


def validate_parameters(
    model: TorqueModel,
    parameters: Float[ndarray, " p"],
    recordings: tuple[ProcessedRecording, ...],
) -> Validation:
    """How well full parameters predict the torque of recordings."""
    predicted = [
        # The filter is linear: the torque of all columns is one column to filter.
        recording.columns(
            lambda motion: model.torque(parameters, motion)[:, :, None], remembers=model.remembers
        )[:, :, 0]
        for recording in recordings
    ]
    measured, certainty = (
        np.concatenate([getattr(recording, name) for recording in recordings])
        for name in ("tau", "certainty")
    )
    return validate(np.concatenate(predicted), measured, certainty)


def _estimate(
    plain: Calibration,
    blocks: tuple[JointFactors, ...],
    settings: FeasibleSettings,
    prior: Float[ndarray, " inertial"] | None,
) -> tuple[FeasibleEstimate, WeightCurve | None, Float[ndarray, " joints"]]:
    """The estimate, how its weight was chosen, and the variances that its data are weighted by."""
    model, variances = plain.model, plain.estimate.joint_variances
    data = JointFactors.join(blocks)
    whole = data.weighted(variances)
    problem = build_problem(
        model,
        whole,
        settings.demands or FeasibleSet.of(model),
        reference_bodies(model, whole, prior),
        Regularisation(
            settings.weights[0] if settings.weight is None else settings.weight, settings.kind
        ),
    )
    curve = None
    if settings.weight is None:
        curve = cross_validate(
            problem, blocks, variances, weights=settings.weights, folds=settings.folds
        )
        problem = problem.with_weight(curve.weight)
    fit = solve_reweighted(problem, data, variances)
    estimate = complete_estimate(model, fit.problem, fit.solution, has_prior=prior is not None)
    return estimate, curve, fit.variances


def _changes(
    estimate: FeasibleEstimate, inertials: FileInertials, spread: Bootstrap
) -> tuple[LinkChange, ...]:
    if inertials.known is None:
        return ()
    return link_changes(
        tuple(joint.link for joint in estimate.robot.joints),
        inertials.known,
        estimate.robot.parameters,
        spread.samples,
        estimate.problem,
    )


def _base_feasibility(
    plain: Calibration,
    values: Float[ndarray, " base"],
    estimate: FeasibleEstimate,
    demands: FeasibleSet | None,
) -> tuple[BaseFeasibility | None, str]:
    """The answer, or why there is none: it is asked for information, and costs no estimate."""
    try:
        return base_feasibility(
            plain.model, plain.base, values, demands=demands, reference=estimate.reference
        ), ""
    except SolverFailed as failure:
        return None, str(failure)


def _second_opinion(estimate: FeasibleEstimate) -> tuple[FeasibleSolution | None, str]:
    other: SolverName = "barrier" if estimate.solution.solver == "clarabel" else "clarabel"
    try:
        return solve_problem(estimate.problem, (other,)), ""
    except SolverFailed as failure:
        return None, "; ".join(failure.attempts) or str(failure)
