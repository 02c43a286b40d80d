"""Whether an arm's effort limits go with the inertia that its file states.

Effort limits hold for a nominal model. They leave room for a design where the arm can stand
within them in some posture, and where they allow it more than hardly any motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import qmc

from oed.design.joint_sums import roomiest_posture
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.errors import NoUsableResult

STANDING_SHARE = 0.9  # of an effort limit that gravity alone may take
POSTURES = 4096  # looked at, where the arm cannot stand at mid-range; a power of two for Sobol
# A motion of a hundredth of the speed that velocity and acceleration limits allow: ten times
# more than heavy arms with weak drives are from it, and far from inertia in other units, which
# is off by a thousand or more.
HARDLY = 0.01


class EffortTooSmall(NoUsableResult):
    """By the file's inertia the effort limits leave no room for a design.

    Attributes:
        joint: Name of the joint that lacks most.
        ratio: Torque that it needs over its effort limit.
    """

    def __init__(self, message: str, joint: str, ratio: float) -> None:
        super().__init__(message)
        self.joint = joint
        self.ratio = ratio


@dataclass(frozen=True)
class Stand:
    """A posture in which an arm can hold itself.

    Attributes:
        posture: (n,) [rad or m].
        shares: (n,) of each effort limit that gravity takes there.
    """

    posture: Float[ndarray, " joints"]
    shares: Float[ndarray, " joints"]


def find_stand(model: TorqueModel, parameters: Float[ndarray, "models parameters"]) -> Stand:
    """Mid-range (by sums of positions too) where the arm can stand there, else the easiest of many postures.

    Args:
        model: Of the torque; position limits of its robot are finite.
        parameters: (m, p) with each of which the arm is to stand: the nominal ones, and others.

    Raises:
        EffortTooSmall: If gravity takes too much of an effort limit in every posture.
    """
    limits = model.robot.limits
    lower, upper = limits.position.T
    grid = lower + qmc.Sobol(model.robot.n, scramble=False).random(POSTURES) * (upper - lower)
    sums = grid @ limits.sum_factors.T
    is_within = ((limits.sum_bounds[:, 0] < sums) & (sums < limits.sum_bounds[:, 1])).all(axis=1)
    postures = np.vstack([roomiest_posture(limits), grid[is_within]])
    still = np.zeros_like(postures)
    columns = model.columns(Motion(np.zeros(len(postures)), postures, still, still))
    torque = np.abs(columns @ parameters.T).max(axis=2)
    shares = torque / np.abs(limits.torque).min(axis=1)
    worst = shares.max(axis=1)
    best = 0 if worst[0] <= STANDING_SHARE else int(worst.argmin())
    if worst[best] > STANDING_SHARE:
        joint = int(shares[best].argmax())
        name, ratio = model.robot.joint_names[joint], float(worst[best])
        raise EffortTooSmall(
            f"{model.robot.source}: by the file's inertia joint {name} needs {ratio:.3g} times its "
            f"effort limit to hold the arm still, in the easiest of {POSTURES} postures: correct "
            "effort limits or masses in the file, or design without effort limits (--no-torque)",
            name,
            ratio,
        )
    return Stand(postures[best], shares[best])


def check_room(
    model: TorqueModel,
    nominal: Float[ndarray, " parameters"],
    motions: Sequence[Motion],
    shares: Sequence[float],
) -> None:
    """Refuse effort limits that allow hardly any motion.

    Args:
        model: Of the torque.
        nominal: (p,) parameters.
        motions: That use all that the other limits allow.
        shares: What the effort limits leave of each, from 0 to 1.

    Raises:
        EffortTooSmall: If they leave less than `HARDLY` of every one.
    """
    if max(shares) >= HARDLY:
        return
    effort = np.abs(model.robot.limits.torque).min(axis=1)
    needed = np.median([np.abs(model.torque(nominal, m)).max(axis=0) for m in motions], axis=0)
    ratios = needed / effort
    joint = int(ratios.argmax())
    name, ratio = model.robot.joint_names[joint], float(ratios[joint])
    raise EffortTooSmall(
        f"{model.robot.source}: by the file's inertia joint {name} needs {ratio:.2g} times its "
        "effort limit to move as its velocity and acceleration limits allow, and the effort limits "
        f"leave hardly any motion ({max(shares):.1g} of it): the inertia is probably in other units "
        "(kg mm^2 or g mm^2 where kg m^2 is due), or the effort limit is (kN m where N m is due); "
        "correct the file, or design without effort limits (--no-torque)",
        name,
        ratio,
    )
