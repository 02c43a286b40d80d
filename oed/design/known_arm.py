"""What is known of an arm before a motion is designed: its drives, its friction, its model's errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.problem import DesignProblem
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.effects import Coulomb, TorqueOffset, Viscous, with_columns
from oed.dynamics.effects.load import LoadFriction
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel

STATES = 400  # within the limits, over which torque that drives need is averaged, and columns
# As shares of the torque that a drive is made for: what currents leave unexplained, and Coulomb
# friction, of a UR5 and a UR10 (150 and 28 N m; 0.8 and 0.1 N m; 9 and 1.5 N m).
NOISE = 0.005
FRICTION = 0.06
# Where the file states no limit: a drive's torque over the rms that the arm needs, and the least
# drive beside the largest.
SPARE = 3.0
LEAST_DRIVE = 0.05
# What is estimated beside the load: as in `oed.estimation.load`.
FRICTION_CHANGE = 1.0  # of each term of friction over speed, from one day to another
LOAD_FRICTION = 0.2  # of what a gear carries, that it may lose
LEAST_FRICTION = 0.001  # of a drive's torque, behind torque sensors
WIDE = 10.0  # times the largest drive's torque that a parameter may make of which nothing is known


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


def expected(
    model: TorqueModel,
    base: BaseParameters,
    sizes: Float[ndarray, " joints"],
    known: KnownTorqueModel | None,
) -> tuple[Float[ndarray, " base"], Float[ndarray, " base"]]:
    """(b,) deviation of each parameter of which nothing is known, and by which it changes in days."""
    robot = model.robot
    speed = np.abs(robot.limits.velocity).max(axis=1)
    coulomb, viscous = FRICTION * sizes, FRICTION * sizes / speed
    offset = LEAST_FRICTION * sizes
    for effect, place in with_columns(() if known is None else known.torque_model.effects):
        value = float(np.abs(known.parameters[place]).max(initial=0.0)) if known else 0.0
        if isinstance(effect, Coulomb):
            coulomb[effect.joint] = max(value, LEAST_FRICTION * sizes[effect.joint])
        elif isinstance(effect, Viscous):
            j = effect.joint
            viscous[j] = max(value, LEAST_FRICTION * sizes[j] / speed[j])
        elif isinstance(effect, TorqueOffset):
            offset[effect.joint] = max(value, offset[effect.joint])
    columns = base.reduce(model.columns(random_motion(robot, STATES, np.random.default_rng(0))))
    wide = WIDE * sizes.max() / np.sqrt(np.mean(columns**2, axis=(0, 1)))
    change = np.zeros(len(base))
    owners = [effect for effect in model.effects for _ in effect.parameters]
    for k, column in enumerate(base.columns):
        effect = owners[column]
        if isinstance(effect, Coulomb | Stribeck):
            change[k] = FRICTION_CHANGE * coulomb[effect.joint]
        elif isinstance(effect, Viscous):
            change[k] = FRICTION_CHANGE * viscous[effect.joint]
        elif isinstance(effect, TorqueOffset):
            change[k] = FRICTION_CHANGE * offset[effect.joint]
        elif isinstance(effect, LoadFriction):
            wide[k] = LOAD_FRICTION
    return wide, change


def covariance_of(
    known: KnownTorqueModel, base: BaseParameters, wide: Float[ndarray, " base"]
) -> Float[ndarray, "base base"]:
    """Covariance of the arm's base parameters by a model; wide where nothing was estimated."""
    own = base.regrouping[:, : len(known.parameters)]
    covariance = own @ known.covariance @ own.T
    nothing = np.diag(covariance) <= 0
    return covariance + np.diag(np.where(nothing, wide, 0.0) ** 2)


def drive_sizes(arm: DesignProblem) -> Float[ndarray, " joints"]:
    """(n,) torque that each drive is made for [N m]: its limit, or what the arm needs of it.

    Drives are chosen by that, and so are their friction and the noise of their currents.
    """
    robot = arm.model.robot
    inertial = robot.parameters
    needed = np.ones(robot.n)
    if np.any(inertial):
        whole = np.zeros(len(arm.model.parameters))
        whole[: len(inertial)] = inertial
        within = random_motion(robot, STATES, np.random.default_rng(0))
        needed = SPARE * np.sqrt(np.mean(arm.model.torque(whole, within) ** 2, axis=0))
        needed = np.maximum(needed, LEAST_DRIVE * needed.max())
    limit = np.abs(robot.limits.torque).max(axis=1)
    return np.where(np.isfinite(limit), limit, needed)
