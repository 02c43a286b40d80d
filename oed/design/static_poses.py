"""Postures in which an arm at rest tells most about what it holds, where a motion is not allowed.

At rest a joint feels the load's weight alone: mass and first moments, four numbers. Postures are taken
one by one, each the one that adds most to log det of the information, out of many that are within the
limits and clear (Fedorov 1972, "Theory of Optimal Experiments", section 3.1).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.load_problem import load_model
from oed.dynamics.base_parameters import find_base_parameters
from oed.dynamics.motion import Motion
from oed.errors import NoUsableResult
from oed.robot import Robot

CANDIDATES = 1000  # random postures, of which the best are taken one after another; assumed
WEIGHT = 4  # parameters that weight tells of: mass and first moments
IDLE = 1e-9  # of the largest weight: a joint that changes it by less is idle
RIDGE = 1e-9  # of the largest information: the first postures leave directions open


def static_poses(
    robot: Robot,
    joint: int,
    count: int,
    variance: Float[ndarray, " joints"],
    rng: np.random.Generator,
    *,
    is_clear: Callable[[Float[ndarray, " joints"]], bool] = lambda _: True,
) -> Float[ndarray, "count joints"]:
    """Postures, in an order of short ways from one to the next.

    Args:
        robot: With finite position limits.
        joint: Whose body holds the load.
        count: How many postures.
        variance: (n,) of each joint's torque at rest [N^2 m^2].
        rng: Of the candidates.
        is_clear: Whether a posture may be taken.

    Raises:
        NoUsableResult: If no posture is clear, or weight tells nothing at this place.
    """
    q = _candidates(robot, joint, rng)
    q = q[[is_clear(posture) for posture in q]]
    if not len(q):
        raise NoUsableResult(
            "no posture within the limits is clear: widen --box, or --no-clearance"
        )
    weight = _weight(robot, joint, q) / np.sqrt(variance)[:, None]
    told = load_model(robot, joint).parameters[:WEIGHT]
    if not np.any(weight):
        raise NoUsableResult("at rest no joint feels what is held there: the arm moves level only")
    kept = find_base_parameters(weight.reshape(-1, WEIGHT), told).columns
    gain = np.einsum("kjp,kjq->kpq", weight[:, :, kept], weight[:, :, kept])
    total = RIDGE * np.trace(gain.mean(axis=0)) * np.eye(len(kept))
    taken: list[int] = []
    for _ in range(count):
        worth = np.linalg.slogdet(total + gain)[1]
        worth[taken] = -np.inf
        best = int(np.argmax(worth))
        taken.append(best)
        total = total + gain[best]
    return _short_way(q[taken])


def _candidates(
    robot: Robot, joint: int, rng: np.random.Generator
) -> Float[ndarray, "candidates joints"]:
    """Random postures within a turn; joints that the weight does not depend on stay in the middle."""
    bounds = robot.limits.position.copy()
    turns = np.array([each.kind == "revolute" for each in robot.joints])
    bounds[turns] = np.clip(bounds[turns], -np.pi, np.pi)
    wide = bounds[:, 0] < bounds[:, 1]
    bounds[~wide] = robot.limits.position[~wide]  # a range that lies beyond a turn
    q = rng.uniform(bounds[:, 0], bounds[:, 1], (CANDIDATES, robot.n))
    weight = _weight(robot, joint, q)
    for j, middle in enumerate(bounds.mean(axis=1)):
        moved = q.copy()
        moved[:, j] = middle
        if np.allclose(_weight(robot, joint, moved), weight, atol=IDLE * np.abs(weight).max()):
            q = moved
    return q


def _weight(
    robot: Robot, joint: int, q: Float[ndarray, "poses joints"]
) -> Float[ndarray, "poses joints 4"]:
    """Torque at rest per unit of mass and first moments."""
    still = np.zeros_like(q)
    motion = Motion(np.arange(len(q)) * 1.0, q, still, still)
    return load_model(robot, joint).columns(motion)[:, :, :WEIGHT]


def _short_way(q: Float[ndarray, "count joints"]) -> Float[ndarray, "count joints"]:
    """From the first posture always to the nearest that is left."""
    order, left = [0], list(range(1, len(q)))
    while left:
        nearest = min(left, key=lambda k: float(np.abs(q[k] - q[order[-1]]).max()))
        order.append(nearest)
        left.remove(nearest)
    return q[order]
