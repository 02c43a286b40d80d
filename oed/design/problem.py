"""The design problem, built once and handed to every optimiser."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import CRITERIA, Criterion, condition, cost, cost_and_slope, log10_det
from oed.design.fast_information import FastInformation
from oed.design.joint_sums import JointSums
from oed.design.limits import (
    KINEMATIC,
    Certificate,
    certify,
    check_limits,
    fill,
    repair,
    sampled_ranges,
    violation_of,
)
from oed.design.nominal_torque import NominalTorque, largest_factor
from oed.design.torque_range import proven_torque_range
from oed.design.trajectories import TrajectoryClass
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.compiled import CompiledRegressor, compile_regressor
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits

DENSE = 1000  # instants of the fast look at the limits
CONTINUOUS = 4000  # instants of the average over continuous time


@dataclass(frozen=True)
class DesignProblem:
    """Find the motion of a class that tells most about the base parameters.

    Attributes:
        model: The torque model.
        base: Its base parameters, b of them.
        trajectory: The class of motions.
        limits: What the motion must keep at all t. Torque limits count only with `nominal`.
        instants: (N,) sampled instants [s]; the criterion's rows are N n.
        criterion: "J_k", "J_d", "A" or "E".
        covariance: R_v of the torque [N^2 m^2], (n,) or (n, n); the identity if None.
        prior: (b, b) information already at hand.
        scaling: (b,) factors of the columns, so that parameters of different units compare.
        nominal: (p,) parameters of the model by which torque is predicted; None to leave
            torque free.
        stand: (n,) posture in which the nominal torque is within its limits, towards which a
            motion that needs too much of it is brought; its own centre if None.
        sign_width: Smoothing of the velocity sign where a gradient is asked for [rad/s].
        native: Whether to compile the regressor to machine code where possible.
    """

    model: TorqueModel
    base: BaseParameters
    trajectory: TrajectoryClass
    limits: JointLimits
    instants: Float[ndarray, " samples"]
    criterion: Criterion = "J_d"
    covariance: Float[ndarray, "..."] | None = None
    prior: Float[ndarray, "base base"] | None = None
    scaling: Float[ndarray, " base"] | None = None
    nominal: Float[ndarray, " parameters"] | None = None
    stand: Float[ndarray, " joints"] | None = None
    sign_width: float = 0.02
    native: bool = True

    def __post_init__(self) -> None:
        if self.criterion not in CRITERIA:
            raise ValueError(f"criterion {self.criterion!r} is none of {CRITERIA}")
        if self.trajectory.joints != self.model.robot.n:
            raise ValueError(
                f"trajectories of {self.trajectory.joints} joints, robot of {self.model.robot.n}"
            )
        check_limits(self.limits)

    def __getstate__(self) -> dict[str, object]:
        """Without the compiled code, which every process loads for itself."""
        return {k: v for k, v in self.__dict__.items() if k not in ("regressor", "fast", "_torque")}

    def slower(self, scale: float) -> DesignProblem:
        """The problem whose z is the same way through space at `scale` times the speed.

        Raises:
            ValueError: If the class has no such z.
        """
        if scale == 1.0:
            return self
        trajectory = self.trajectory.slower(scale)
        return dataclasses.replace(self, trajectory=trajectory, instants=self.instants / scale)

    @property
    def is_told_before(self) -> bool:
        """Whether more counts than what the motion itself tells."""
        return self.prior is not None

    @property
    def size(self) -> int:
        """Number of decision variables."""
        return self.trajectory.size

    @property
    def rows(self) -> int:
        """Rows of the regressor, N n."""
        return len(self.instants) * self.model.robot.n

    @cached_property
    def regressor(self) -> CompiledRegressor:
        """The base regressor, compiled."""
        return compile_regressor(self.model, self.base, native=self.native)

    @cached_property
    def fast(self) -> FastInformation:
        """Information and its gradient."""
        return FastInformation(self.regressor, self.covariance)

    def information(
        self, z: Float[ndarray, " size"], *, scaled: bool = True, prior: bool = True
    ) -> Float[ndarray, "base base"]:
        """Lambda at the instants, with the exact velocity sign.

        Args:
            z: The motion.
            scaled: Whether to apply the column scaling.
            prior: Whether to add the prior information.
        """
        bare = self.fast.information(self.trajectory.motion(z, self.instants))
        return self._complete(bare, scaled, prior)

    def continuous_information(
        self,
        z: Float[ndarray, " size"],
        *,
        scaled: bool = True,
        prior: bool = True,
        points: int = CONTINUOUS,
    ) -> Float[ndarray, "base base"]:
        """Lambda of N instants spread evenly over continuous time: N times its mean.

        With the rows of the paper's sampled criterion, so that J_d compares. Midpoint rule.
        """
        t = (np.arange(points) + 0.5) * (self.trajectory.horizon / points)
        bare = self.fast.information(self.trajectory.motion(z, t)) * (len(self.instants) / points)
        return self._complete(bare, scaled, prior)

    def worth(self, z: Float[ndarray, " size"]) -> dict[str, float]:
        """J_k and J_d (log10) of the information at the instants, without prior or scaling."""
        information = self.information(z, scaled=False, prior=False)
        return {"J_k": condition(information), "J_d_log10": log10_det(information)}

    def cost(self, z: Float[ndarray, " size"]) -> float:
        """The criterion to be minimised, with the exact sign; infinite where singular."""
        return cost(self.information(z), self.criterion)

    def cost_and_gradient(
        self,
        z: Float[ndarray, " size"],
        *,
        sign_width: float | None = None,
        exponent: float = np.inf,
        dearer: float = 1.0,
    ) -> tuple[float, Float[ndarray, " size"]]:
        """The criterion with a smooth sign, and its gradient.

        Args:
            z: The motion.
            sign_width: Of the smooth sign [rad/s]; the problem's own if None.
            exponent: Of the Schatten norms that smooth J_k and E; infinite for the criterion.
            dearer: Times the usual price of excess torque.
        """
        width = self.sign_width if sign_width is None else sign_width
        motion = self.trajectory.motion(z, self.instants)
        bare, entries = self.fast.information_and_entries(motion, width)
        value, slope = self._worth_and_slope(bare, exponent)
        if not np.isfinite(value):
            return value, np.zeros(self.size)
        adjoint = self.fast.adjoint(entries, slope)
        if self.limits_torque:
            penalty, push = self._torque.penalty(entries)
            value, adjoint = value + dearer * penalty, adjoint + dearer * push
        adjoints = self.regressor.pull_back(motion, adjoint, width)
        return value, self.trajectory.pull_back(z, self.instants, adjoints)

    def violation(self, z: Float[ndarray, " size"]) -> float:
        """Worst violation of the kinematic limits on a dense grid, relative to the limit."""
        t = np.linspace(0.0, self.trajectory.horizon, DENSE)
        ranges = sampled_ranges(self.trajectory, z, t)
        beyond = [violation_of(ranges[k], getattr(self.limits, k)) for k in KINEMATIC]
        if self.limits.sums:
            sums = JointSums(self.trajectory, self.limits.sum_factors).derivative(z, t, 0)
            seen = np.stack([sums.min(axis=0), sums.max(axis=0)], axis=1)
            beyond.append(violation_of(seen, self.limits.sum_bounds))
        return float(np.concatenate(beyond).max())

    def certificate(self, z: Float[ndarray, " size"]) -> Certificate:
        """Proven bounds on the motion for all t, and on the nominal torque where limited.

        Raises:
            TorqueNotBounded: If torque is limited and an effect of the nominal model cannot be
                evaluated on intervals.
        """
        return certify(self.trajectory, z, self.limits, self.torque_range(z))

    def torque_range(self, z: Float[ndarray, " size"]) -> Float[ndarray, "joints 2"] | None:
        """Proven bounds on the nominal torque [N m]; None where torque is not limited."""
        if self.nominal is None or not self.limits_torque:
            return None
        return proven_torque_range(self.model, self.nominal[None], self.trajectory, z)

    @property
    def limits_torque(self) -> bool:
        """Whether a nominal model and a torque limit are both there."""
        return self.nominal is not None and bool(np.isfinite(self.limits.torque).any())

    def repair(self, z: Float[ndarray, " size"]) -> Float[ndarray, " size"]:
        """The motion brought within the limits by scaling and shifting each joint.

        Where torque is limited, all joints then shrink by one factor, towards `stand`, until the
        torque at a thousand instants stays a part in fifty inside; the certificate proves the
        rest.
        """
        return self._within_torque(repair(self.trajectory, z, self.limits))

    def quick_repair(self, z: Float[ndarray, " size"]) -> Float[ndarray, " size"]:
        """As `repair`, faster, and a fraction of a percent inside the limits."""
        return self._within_torque(repair(self.trajectory, z, self.limits, is_quick=True))

    def random_start(self, rng: np.random.Generator) -> Float[ndarray, " size"]:
        """A random motion of the class, every joint scaled until it touches one of its limits."""
        z = fill(self.trajectory, self.trajectory.draw(rng), self.limits)
        return self._within_torque(z)

    @cached_property
    def _torque(self) -> NominalTorque:
        if self.nominal is None:
            raise ValueError("no nominal parameters to limit the torque of")
        columns = self.base.from_standard(self.nominal)[None]
        return NominalTorque.of(self.regressor, columns, self.limits.torque)

    def torque_factor(self, z: Float[ndarray, " size"]) -> float:
        """Share of a motion, from 0 to 1, that the torque limits leave of it."""
        if not self.limits_torque:
            return 1.0
        t = np.linspace(0.0, self.trajectory.horizon, DENSE)

        def excess(factor: float) -> float:
            motion = self.trajectory.motion(self._smaller(z, factor), t)
            return self._torque.excess(self.regressor.entries(motion))

        return largest_factor(excess)

    def _within_torque(self, z: Float[ndarray, " size"]) -> Float[ndarray, " size"]:
        factor = self.torque_factor(z)
        return z if factor == 1.0 else self._smaller(z, factor)

    def _smaller(self, z: Float[ndarray, " size"], factor: float) -> Float[ndarray, " size"]:
        """The motion shrunk by a factor, its centre brought as much nearer to `stand`."""
        smaller = self.trajectory.shrink(z, np.full(self.trajectory.joints, factor))
        if self.stand is None:
            return smaller
        return self.trajectory.shift(
            smaller, (1 - factor) * (self.stand - self.trajectory.centre(z))
        )

    def _worth_and_slope(
        self, bare: Float[ndarray, "columns columns"], exponent: float
    ) -> tuple[float, Float[ndarray, "columns columns"]]:
        """The criterion of the rows' own information, and its gradient by that."""
        value, slope = cost_and_slope(self._complete(bare), self.criterion, exponent)
        return value, self._of_rows(bare, slope)

    def _of_rows(
        self,
        bare: Float[ndarray, "columns columns"],  # noqa: ARG002  # of which others make use
        slope: Float[ndarray, "base base"],
    ) -> Float[ndarray, "columns columns"]:
        """Gradient by the rows' own information of what has the gradient `slope` by Lambda."""
        return slope if self.scaling is None else slope * np.outer(self.scaling, self.scaling)

    def _complete(
        self, information: Float[ndarray, "base base"], scaled: bool = True, prior: bool = True
    ) -> Float[ndarray, "base base"]:
        if prior and self.prior is not None:
            information = information + self.prior
        if scaled and self.scaling is not None:
            information = information * np.outer(self.scaling, self.scaling)
        return information
