"""What a nominal and a robust design are worth under the same drawn models: the price and the gain."""

from __future__ import annotations

from dataclasses import dataclass

from jaxtyping import Float
from numpy import ndarray

from oed.counted import counted
from oed.design.criteria import Criterion, value_of
from oed.design.limits import Certificate, violation_of
from oed.design.problem import CONTINUOUS
from oed.design.robust_problem import Aim, RobustProblem
from oed.design.status import LimitStatus


@dataclass(frozen=True)
class Worth:
    """One motion under drawn models; criteria as they are optimised, what is known before counted.

    Attributes:
        nominal: The criterion of the nominal model.
        expected: Its mean over the drawn models: of J_d itself, of the logarithm of all others.
        worst: The worst of them.
        largest_share: Largest share of a torque limit under any drawn model, at many instants; None
            where torque is not limited.
        exceeding: How many drawn models exceed a torque limit at these.
    """

    nominal: float
    expected: float
    worst: float
    largest_share: float | None
    exceeding: int

    @classmethod
    def of(cls, problem: RobustProblem, z: Float[ndarray, " size"]) -> Worth:
        """Of a motion."""
        costs, criterion = problem.costs(z), problem.criterion
        shares = problem.torque_shares(z, CONTINUOUS)[1:] if problem.limits_torque else None
        return cls(
            nominal=value_of(problem.alone.cost(z), criterion),
            expected=value_of(float(costs.mean()), criterion),
            worst=value_of(float(costs.max()), criterion),
            largest_share=None if shares is None else float(shares.max()),
            exceeding=0 if shares is None else int((shares > 1.0).any(axis=1).sum()),
        )


@dataclass(frozen=True)
class RobustWorth:
    """A nominal and a robust design, side by side.

    Attributes:
        aim: What the robust one was made for.
        criterion: Which.
        scenarios: How many models were drawn.
        has_shapes: Whether their information differs.
        nominal_design: The motion for the nominal model alone, found with as many evaluations.
        robust_design: The other.
    """

    aim: Aim
    criterion: Criterion
    scenarios: int
    has_shapes: bool
    nominal_design: Worth
    robust_design: Worth

    @classmethod
    def of(
        cls, problem: RobustProblem, nominal: Float[ndarray, " size"], z: Float[ndarray, " size"]
    ) -> RobustWorth:
        """Both under the same models.

        Args:
            problem: With the drawn models.
            nominal: The motion for the nominal model.
            z: The robust one.
        """
        count, worths = len(problem.scenarios), (Worth.of(problem, own) for own in (nominal, z))
        return cls(problem.aim, problem.criterion, count, problem.has_shapes, *worths)


def torque_of_drawn(
    problem: RobustProblem, z: Float[ndarray, " size"], certificate: Certificate
) -> tuple[LimitStatus, ...]:
    """Whether torque limits are kept under every drawn model; empty where torque is not limited.

    Args:
        problem: With the drawn models.
        z: The motion.
        certificate: Of it.
    """
    if not problem.limits_torque:
        return ()
    name = f"torque under {counted(len(problem.scenarios), 'drawn model')}"
    if not problem.not_bounded and certificate.torque is not None:
        beyond = float(violation_of(certificate.torque, problem.limits.torque).max())
        if beyond <= 0.0:
            return (LimitStatus(name, "proven"),)
        return (LimitStatus(name, "not kept", f"beyond by {beyond:.3g} of the half range"),)
    shares = problem.torque_shares(z, CONTINUOUS)[1:]
    worst = float(shares.max())
    joint = problem.model.robot.joint_names[int(shares.max(axis=0).argmax())]
    told = f"{worst:.1%} of the limit of {joint} at {CONTINUOUS} instants; {problem.not_bounded}"
    return (LimitStatus(name, "checked" if worst <= 1.0 else "not kept", told),)
