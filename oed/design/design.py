"""A finished design: a motion, what it tells, and the proof that it keeps its limits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import condition, log10_det
from oed.design.limits import MARGIN, Certificate
from oed.design.optimisers.result import OptimiserResult
from oed.design.problem import DesignProblem
from oed.design.status import DesignStatus, LimitStatus, certified
from oed.dynamics.motion import Motion

PROOFS = 20  # attempts, each scaled down ten times more, at proving a point that repair returned


@dataclass(frozen=True)
class Design:
    """A motion with its criteria, and what is proven of its limits.

    Attributes:
        problem: What it is the answer to.
        z: (size,) its decision variables.
        certificate: Bounds proven for all t.
        cost: The exact criterion as a logarithm, to be minimised.
        J_k: cond Lambda at the instants, without prior or column scaling.
        J_d: log10 det Lambda at the instants, likewise.
        J_k_continuous: cond of the information averaged over continuous time.
        J_d_continuous: log10 det of N times that average, N the number of instants.
        J_k_scaled: cond Lambda with column scaling, without prior; None where the problem scales
            no columns.
        optimiser: Name of the optimiser.
        seed: Of its random generator.
        cpu_s: What it spent [s].
        evaluations: Likewise.
        status: Everything that it was asked to keep, and whether it does.
    """

    problem: DesignProblem
    z: Float[ndarray, " size"]
    certificate: Certificate
    cost: float
    J_k: float
    J_d: float
    J_k_continuous: float
    J_d_continuous: float
    J_k_scaled: float | None
    optimiser: str = ""
    seed: int | None = None
    cpu_s: float = 0.0
    evaluations: int = 0
    status: DesignStatus = field(default_factory=lambda: DesignStatus(()))

    @classmethod
    def from_result(
        cls,
        problem: DesignProblem,
        result: OptimiserResult,
        *,
        optimiser: str = "",
        seed: int | None = None,
        others: Iterable[LimitStatus] = (),
    ) -> Design:
        """Repair a result, prove what can be proven of its limits, and evaluate it exactly.

        Args:
            problem: What was asked.
            result: Of the optimiser.
            optimiser: Its name.
            seed: Of its random generator.
            others: Limits beside those of the problem, such as effort limits left out of it.
        """
        z, certificate = prove(problem, result.z)
        sampled = problem.information(z, scaled=False, prior=False)
        continuous = problem.continuous_information(z, scaled=False, prior=False)
        return cls(
            problem=problem,
            z=z,
            certificate=certificate,
            cost=problem.cost(z),
            J_k=condition(sampled),
            J_d=log10_det(sampled),
            J_k_continuous=condition(continuous),
            J_d_continuous=log10_det(continuous),
            J_k_scaled=None
            if problem.scaling is None
            else condition(problem.information(z, prior=False)),
            optimiser=optimiser,
            seed=seed,
            cpu_s=result.cpu_s,
            evaluations=result.evaluations,
            status=DesignStatus(
                (*certified(certificate, problem.limits, problem.model.robot.joint_names), *others),
                result.status,
            ),
        )

    @property
    def horizon(self) -> float:
        """Length of the motion [s]."""
        return self.problem.trajectory.horizon

    def motion(self, t: Float[ndarray, " samples"]) -> Motion:
        """Position, velocity and acceleration at instants t [s]."""
        return self.problem.trajectory.motion(self.z, t)

    @cached_property
    def information(self) -> Float[ndarray, "base base"]:
        """Lambda at the instants without prior or scaling: a prior for the next design."""
        return self.problem.information(self.z, scaled=False, prior=False)

    @property
    def coefficients(self) -> dict[str, ndarray]:
        """The motion's coefficients by name."""
        return self.problem.trajectory.describe(self.z)


def prove(
    problem: DesignProblem, z: Float[ndarray, " size"]
) -> tuple[Float[ndarray, " size"], Certificate]:
    """A point next to z, or z itself, with a certificate that it keeps the limits.

    Repair puts a motion a billionth inside; should rounding still stand in the way of a proof,
    it is scaled down a little more.
    """
    z = problem.repair(z)
    certificate = problem.certificate(z)
    margin = MARGIN
    for _ in range(PROOFS):
        if certificate.is_feasible:
            break
        joints = problem.trajectory.joints
        z = problem.repair(problem.trajectory.shrink(z, np.full(joints, 1 - margin)))
        certificate = problem.certificate(z)
        margin = min(10 * margin, 0.5)
    return z, certificate
