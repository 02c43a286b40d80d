"""What recordings leave open of a load, and what motion would tell it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion, random_motion
from oed.estimation.load.payload import Payload
from oed.estimation.load.quantities import NAMES

# States within the limits that a column is compared with: enough for a rms to a few per cent.
STATES = 400
FEW = 0.5  # share of what the limits allow, below which a motion is called small
# Parameters by the quantity of which they tell most.
WORDS = {
    "mass": "the mass",
    **{axis: f"the centre of mass along {axis}" for axis in "xyz"},
    **{name: f"the inertia {name} about the centre of mass" for name in NAMES[4:]},
}


@dataclass(frozen=True)
class OpenQuantity:
    """A number of the load that the recordings do not tell.

    Attributes:
        name: Of the quantity.
        what: The same in words.
        remedy: What would tell it.
    """

    name: str
    what: str
    remedy: str


def open_quantities(payload: Payload) -> tuple[OpenQuantity, ...]:
    """Every quantity whose interval is wider than the load, with what would tell it."""
    found = []
    for k, quantity in enumerate(payload.quantities):
        if quantity.is_determined:
            continue
        remedy = _remedy(payload, k)
        found.append(OpenQuantity(quantity.name, WORDS[quantity.name], remedy))
    return tuple(found)


def _remedy(payload: Payload, k: int) -> str:
    """Which joint feels the parameter of number k most, by what, and how much of that was used."""
    robot = payload.model.arm.robot
    if payload["mass"].interval is None or not payload.is_felt:
        return (
            "a load is not told from none: a heavier load, a longer recording or a quieter torque"
        )
    possible = random_motion(robot, STATES, np.random.default_rng(0))
    noise = np.sqrt(payload.fit.variances)
    felt = _sizes(payload, possible, k) / noise
    if felt.max() == 0 or payload.quantities[k].interval is None:
        return "no motion of this arm: none of its joints feels it"
    joint = int(np.argmax(felt))
    still = _at_rest(possible)
    by_weight = _sizes(payload, still, k)[joint] > FEW * _sizes(payload, possible, k)[joint]
    used = np.sqrt(
        np.mean([_sizes(payload, r.motion, k)[joint] ** 2 for r in payload.equations.recordings])
    ) / (felt[joint] * noise[joint])
    how = "its weight in other postures" if by_weight else "accelerations"
    more = (
        f"the recording uses {used:.0%} of what the limits allow"
        if used < FEW
        else "the recording uses what the limits allow: only more of it helps"
    )
    return f"{how} of joint {robot.joint_names[joint]}: {more}; oed design --payload"


def _sizes(payload: Payload, motion: Motion, k: int) -> Float[ndarray, " joints"]:
    """Rms torque of each joint by a unit of the parameter, about the frame [N m]."""
    model = payload.model
    columns = model.raw_columns(motion)[:, :, model.load]
    # phi about the body's frame by the parameter about the load's frame.
    about = np.linalg.inv(model.frame.from_body)[list(model.kept), k]
    return np.sqrt(np.mean((columns @ about) ** 2, axis=0))


def _at_rest(motion: Motion) -> Motion:
    return Motion(motion.t, motion.q, np.zeros_like(motion.q), np.zeros_like(motion.q))
