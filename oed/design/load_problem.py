"""The motion that tells most about what the arm holds, with what is not known of the arm itself.

Estimated is all that `oed payload` estimates: the arm, known as well as its model says or as a general
motion tells it; the load; friction of any shape over speed, which each day has its own; and friction that
grows with what gears carry. The arm's errors are the same all along the motion, so they are parameters
with a prior and no noise, which would average out. The criterion is the sum of the variances of the load's
ten parameters, each in the unit that matters (A, with all else integrated out). Limits, of torque too, are
those of the arm.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.known_arm import (
    NOISE,
    KnownTorqueModel,
    covariance_of,
    drive_sizes,
    expected,
)
from oed.design.limits import Certificate
from oed.design.problem import DesignProblem
from oed.dynamics.base_parameters import BaseParameters, find_base_parameters
from oed.dynamics.compiled import CompiledRegressor, compile_regressor
from oed.dynamics.effects.load import LoadFriction
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.friction_curve import with_friction_curve
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.models import build_model
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, Robot

STATES = 400  # random ones, over which a load's columns are compared
ARM = "rotor"  # model of an arm of which no model is given
# General motion that an arm is known from where no model is given: as the how-to asks for.
GENERAL = 30.0  # [s]
# In which variances count: 10 g, 5 mm of a kilogram, a kilogram of a decimetre across.
UNITS = (0.01, *(0.005,) * 3, *(0.01,) * 6)


@dataclass(frozen=True)
class LoadProblem(DesignProblem):
    """A design problem of a load, kept within the limits of the arm that holds it.

    Lambda is that of the load alone, all else integrated out: of the load's base parameters, which
    are `base`.

    Attributes:
        arm: The problem of the arm alone: same class of motions, same limits.
        arm_base: Base parameters of the arm, with friction as it is estimated.
        known: (a, a) information about these before the motion.
    """

    arm: DesignProblem = dataclasses.field(kw_only=True)
    arm_base: BaseParameters = dataclasses.field(kw_only=True)
    known: Float[ndarray, "arm arm"] = dataclasses.field(kw_only=True)

    @cached_property
    def regressor(self) -> CompiledRegressor:
        """Of the arm and of its load, side by side."""
        return compile_regressor(self.model, self.joined, native=self.native)

    @property
    def joined(self) -> BaseParameters:
        """The arm's base parameters and the load's, of the same columns: `known` tells them apart."""
        return _side_by_side(self.arm_base, self.base)

    @property
    def is_told_before(self) -> bool:
        """The arm is."""
        return True

    def everything(self, bare: Float[ndarray, "columns columns"]) -> Float[ndarray, "x x"]:
        """Information about arm and load, of a motion's and of what is known of the arm."""
        total = bare.copy()
        own = slice(len(self.known))
        total[own, own] += self.known
        return total

    def slower(self, scale: float) -> LoadProblem:
        """As of any problem; the arm's likewise."""
        if scale == 1.0:
            return self
        arm = self.arm.slower(scale)
        return dataclasses.replace(
            self, arm=arm, trajectory=arm.trajectory, instants=self.instants / scale
        )

    def torque_factor(self, z: Float[ndarray, " size"]) -> float:
        """Share of a motion that the torque limits leave of it."""
        return self.arm.torque_factor(z)

    def certificate(self, z: Float[ndarray, " size"]) -> Certificate:
        """Proven bounds on the motion, and on the arm's nominal torque."""
        return self.arm.certificate(z)

    def _complete(
        self,
        information: Float[ndarray, "columns columns"],
        scaled: bool = True,
        prior: bool = True,
    ) -> Float[ndarray, "base base"]:
        if prior and self.prior is not None:
            information = information + self.prior
        integrated = self._integrating(information)
        told = integrated @ self.everything(information) @ integrated.T
        if scaled and self.scaling is not None:
            told = told * np.outer(self.scaling, self.scaling)
        return (told + told.T) / 2

    def _of_rows(
        self, bare: Float[ndarray, "columns columns"], slope: Float[ndarray, "base base"]
    ) -> Float[ndarray, "columns columns"]:
        integrated = self._integrating(bare if self.prior is None else bare + self.prior)
        if self.scaling is not None:
            slope = slope * np.outer(self.scaling, self.scaling)
        return integrated.T @ slope @ integrated

    def _integrating(
        self, information: Float[ndarray, "columns columns"]
    ) -> Float[ndarray, "base columns"]:
        """T of T Lambda T' = Lambda_ll - Lambda_la Lambda_aa^-1 Lambda_al, which is also its slope."""
        total, own = self.everything(information), slice(len(self.known))
        rest = slice(len(self.known), None)
        unit = 1 / np.sqrt(np.diag(total)[own])
        even = total[own, own] * np.outer(unit, unit)
        shares = np.linalg.solve(even, unit[:, None] * total[own, rest]) * unit[:, None]
        return np.hstack([-shares.T, np.eye(len(self.base))])


def load_problem(arm: DesignProblem, joint: int, known: KnownTorqueModel | None) -> LoadProblem:
    """The problem of a load that a joint's body holds.

    Args:
        arm: The problem of the arm alone.
        joint: Index of the joint.
        known: The arm as it was identified; None takes it for one that a general motion of `GENERAL`
            seconds has told, with usual friction.
    """
    robot = arm.model.robot
    found = build_model(ARM, robot) if known is None else known.torque_model
    alone = _with_open_friction(found)
    model = alone.with_effects(*load_model(robot, joint).effects)
    own, held = base_parameters(alone), _load_base(robot, joint)
    sizes = drive_sizes(arm)
    wide, change = expected(alone, own, sizes, known)
    problem = LoadProblem(
        model=model,
        base=held,
        trajectory=arm.trajectory,
        limits=arm.limits,
        instants=arm.instants,
        criterion="A",
        covariance=(NOISE * sizes) ** 2,
        scaling=np.array([UNITS[k] for k in held.columns]),
        stand=arm.stand,
        sign_width=arm.sign_width,
        native=arm.native,
        arm=arm,
        arm_base=own,
        known=np.diag(1 / wide**2),
    )
    covariance = (
        _told_by_general_motion(problem) if known is None else covariance_of(known, own, wide)
    )
    covariance = covariance + np.diag(change**2)
    std = np.sqrt(np.diag(covariance))
    inner = np.linalg.inv(covariance / np.outer(std, std)) / np.outer(std, std)
    return dataclasses.replace(problem, known=inner)


def load_model(robot: Robot, joint: int) -> TorqueModel:
    """The ten columns of a body that a joint's body holds all the time."""
    return TorqueModel(robot, (PayloadChange(robot, joint, -np.inf, start=0.0),))


def _with_open_friction(model: TorqueModel) -> TorqueModel:
    """A model with friction of any shape, which grows with what the gears of the bare arm carry."""
    reference = ReferenceTorque(model.robot)
    has = {effect.joint for effect in model.effects if isinstance(effect, LoadFriction)}
    more = [LoadFriction(j, reference) for j in range(model.robot.n) if j not in has]
    return with_friction_curve(model).with_effects(*more)


def _load_base(robot: Robot, joint: int) -> BaseParameters:
    """Which of the load's parameters make torque of their own."""
    load = load_model(robot, joint)
    far = random_motion(
        robot.with_limits(JointLimits.unlimited(robot.n)), STATES, np.random.default_rng(0)
    )
    return find_base_parameters(load.regressor(far), load.parameters)


def _side_by_side(arm: BaseParameters, load: BaseParameters) -> BaseParameters:
    """Base parameters of two kinds of columns, and none regrouped from one to the other."""
    own = arm.regrouping.shape[1]
    shape = (len(arm) + len(load), own + load.regrouping.shape[1])
    regrouping = np.zeros(shape)
    regrouping[: len(arm), :own] = arm.regrouping
    regrouping[len(arm) :, own:] = load.regrouping
    return BaseParameters(
        columns=np.append(arm.columns, own + load.columns),
        regrouping=regrouping,
        singular_values=np.append(arm.singular_values, load.singular_values),
        names=arm.names + load.names,
        expressions=arm.expressions + load.expressions,
        units=arm.units + load.units,
        joints=arm.joints + load.joints,
        note=arm.note,
    )


def _told_by_general_motion(problem: LoadProblem) -> Float[ndarray, "arm arm"]:
    """Covariance of the arm's base parameters after random motions of its class, without a load."""
    rng, count = np.random.default_rng(0), len(problem.known)
    horizon = problem.trajectory.horizon
    motions = max(1, round(GENERAL / horizon))
    told = np.zeros((count, count))
    for _ in range(motions):
        motion = problem.trajectory.motion(problem.arm.random_start(rng), problem.instants)
        told += problem.fast.information(motion)[:count, :count]
    told *= GENERAL / (motions * horizon)
    wide = 1 / np.sqrt(np.diag(problem.known))
    return np.linalg.inv(told * np.outer(wide, wide) + np.eye(count)) * np.outer(wide, wide)
