"""The motion that tells most about what the arm holds, the arm itself being known.

Estimated beside the load is what changes from the day on which the arm was identified: Coulomb and viscous
friction, known to a share, and friction that grows with the load. What is not known exactly of the arm
stands in the noise: its torque is foretold with an error, and a joint whose torque is foretold badly
counts for less. The criterion is the sum of the variances of the load's ten parameters, each in the unit
that matters (A, with all else integrated out). Limits, of torque too, are those of the arm.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.limits import Certificate
from oed.design.problem import DesignProblem
from oed.dynamics.base_parameters import find_base_parameters
from oed.dynamics.effects import Coulomb, Effect, Viscous, with_columns
from oed.dynamics.effects.load import LoadFriction
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion, random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, Robot

STATES = 400  # within the limits, over which errors of the arm's torque are averaged
# As shares of the torque that a drive is made for: what currents leave unexplained, and Coulomb
# friction, of a UR5 and a UR10 (150 and 28 N m; 0.8 and 0.1 N m; 9 and 1.5 N m).
NOISE = 0.005
FRICTION = 0.06
# Where the file states no limit: a drive's torque over the rms that the arm needs, and the least
# drive beside the largest.
SPARE = 3.0
LEAST_DRIVE = 0.05


# What is estimated beside the load: as in `oed.estimation.load`.
FRICTION_CHANGE = 0.2  # of Coulomb and viscous friction from one day to another
LOAD_FRICTION = 0.2  # of what a gear carries, that it may lose
LEAST_FRICTION = 0.001  # of a drive's torque, behind torque sensors
OPEN = 1e3  # [kg, kg m, kg m^2] of a load of which nothing is known
# In which variances count: 10 g, 5 mm of a kilogram, a kilogram of a decimetre across.
UNITS = (0.01, *(0.005,) * 3, *(0.01,) * 6)
UNCOUNTED = 30.0  # prior deviations, in which those of friction count: hardly at all


@dataclass(frozen=True)
class KnownTorqueModel:
    """An arm as it was identified.

    Attributes:
        torque_model: Of it.
        parameters: (p,).
        covariance: (p, p).
    """

    torque_model: TorqueModel
    parameters: Float[ndarray, " parameters"]
    covariance: Float[ndarray, "parameters parameters"]


@dataclass(frozen=True)
class LoadProblem(DesignProblem):
    """A design problem of a load, kept within the limits of the arm that holds it.

    Attributes:
        arm: The problem of the arm alone: same class of motions, same limits.
    """

    arm: DesignProblem = dataclasses.field(kw_only=True)

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


def load_problem(arm: DesignProblem, joint: int, known: KnownTorqueModel | None) -> LoadProblem:
    """The problem of a load that a joint's body holds.

    Args:
        arm: The problem of the arm alone.
        joint: Index of the joint.
        known: The arm as it was identified; None takes it as known exactly, with usual friction.
    """
    robot = arm.model.robot
    within = random_motion(robot, STATES, np.random.default_rng(0))
    sizes = drive_sizes(arm, within)
    model = TorqueModel(robot, (*_friction(robot), *load_model(robot, joint).effects))
    far = random_motion(
        robot.with_limits(JointLimits.unlimited(robot.n)), STATES, np.random.default_rng(0)
    )
    base = find_base_parameters(model.regressor(far), model.parameters)
    std, units = _expected(model, robot, sizes, known)
    kept = base.columns
    return LoadProblem(
        model=model,
        base=base,
        trajectory=arm.trajectory,
        limits=arm.limits,
        instants=arm.instants,
        criterion="A",
        covariance=(NOISE * sizes) ** 2 + _foretold(known, within),
        prior=np.diag(1 / std[kept] ** 2),
        scaling=units[kept],
        stand=arm.stand,
        sign_width=arm.sign_width,
        native=arm.native,
        arm=arm,
    )


def load_model(robot: Robot, joint: int) -> TorqueModel:
    """The ten columns of a body that a joint's body holds all the time."""
    return TorqueModel(robot, (PayloadChange(robot, joint, -np.inf, start=0.0),))


def _friction(robot: Robot) -> list[Effect]:
    """What may differ from the day on which the arm was identified."""
    reference = ReferenceTorque(robot)
    joints = range(robot.n)
    plain = [kind(j) for j in joints for kind in (Coulomb, Viscous)]
    return [*plain, *(LoadFriction(j, reference) for j in joints)]


def _expected(
    model: TorqueModel,
    robot: Robot,
    sizes: Float[ndarray, " joints"],
    known: KnownTorqueModel | None,
) -> tuple[Float[ndarray, " parameters"], Float[ndarray, " parameters"]]:
    """(p,) prior standard deviation of each parameter, and the unit in which its variance counts."""
    speed = np.abs(robot.limits.velocity).max(axis=1)
    coulomb, viscous = FRICTION * sizes, FRICTION * sizes / speed
    if known is not None:
        for effect, place in with_columns(known.torque_model.effects):
            value = float(np.abs(known.parameters[place]).max(initial=0.0))
            if isinstance(effect, Coulomb):
                coulomb[effect.joint] = max(value, LEAST_FRICTION * sizes[effect.joint])
            elif isinstance(effect, Viscous):
                viscous[effect.joint] = max(
                    value, LEAST_FRICTION * sizes[effect.joint] / speed[effect.joint]
                )
    std, units = [], []
    for effect in model.effects:
        if isinstance(effect, PayloadChange):
            std += [OPEN] * len(effect.kept)
            units += [UNITS[k] for k in effect.kept]
            continue
        size = (
            FRICTION_CHANGE * coulomb[effect.joint]
            if isinstance(effect, Coulomb)
            else FRICTION_CHANGE * viscous[effect.joint]
            if isinstance(effect, Viscous)
            else LOAD_FRICTION
        )
        std.append(size)
        units.append(UNCOUNTED * size)
    return np.array(std), np.array(units)


def drive_sizes(arm: DesignProblem, motion: Motion) -> Float[ndarray, " joints"]:
    """(n,) torque that each drive is made for [N m]: its limit, or what the arm needs of it.

    Drives are chosen by that, and so are their friction and the noise of their currents.
    """
    robot = arm.model.robot
    inertial = robot.parameters
    needed = np.ones(robot.n)
    if np.any(inertial):
        whole = np.zeros(len(arm.model.parameters))
        whole[: len(inertial)] = inertial
        needed = SPARE * np.sqrt(np.mean(arm.model.torque(whole, motion) ** 2, axis=0))
        needed = np.maximum(needed, LEAST_DRIVE * needed.max())
    limit = np.abs(robot.limits.torque).max(axis=1)
    return np.where(np.isfinite(limit), limit, needed)


def _foretold(known: KnownTorqueModel | None, motion: Motion) -> Float[ndarray, " joints"] | float:
    """(n,) variance of the bare arm's torque as the model foretells it [N^2 m^2]."""
    if known is None:
        return 0.0
    columns = known.torque_model.columns(motion)
    return np.mean(np.einsum("kjp,pq,kjq->kj", columns, known.covariance, columns), axis=0)
