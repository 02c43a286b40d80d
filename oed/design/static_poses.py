"""Postures in which an arm at rest tells most about what it holds, where a motion is not allowed.

At rest a joint feels the load's weight alone: mass and first moments, four numbers. Postures are taken
one by one, each the one that adds most to log det of the information about them, the arm's own errors
integrated out (D_s), out of many that are within the limits and clear (Fedorov 1972, "Theory of Optimal
Experiments", sections 2.10 and 3.1).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.load_problem import LoadProblem, load_model
from oed.dynamics.base_parameters import find_base_parameters
from oed.dynamics.motion import Motion
from oed.errors import NoUsableResult
from oed.robot import Robot

CANDIDATES = 1000  # random postures, of which the best are taken one after another; assumed
WEIGHT = 4  # parameters that weight tells of: mass and first moments
IDLE = 1e-9  # of the largest weight: a joint that changes it by less is idle
RIDGE = 1e-9  # of the largest information: the first postures leave directions open


def static_poses(
    problem: LoadProblem,
    joint: int,
    count: int,
    rng: np.random.Generator,
    *,
    is_clear: Callable[[Float[ndarray, " joints"]], bool] = lambda _: True,
) -> Float[ndarray, "count joints"]:
    """Postures, in an order of short ways from one to the next.

    Args:
        problem: Of the load; its robot has finite position limits.
        joint: Whose body holds the load.
        count: How many postures.
        rng: Of the candidates.
        is_clear: Whether a posture may be taken.

    Raises:
        NoUsableResult: If no posture is clear, or weight tells nothing at this place.
    """
    robot = problem.model.robot
    q = _candidates(robot, joint, rng)
    q = q[[is_clear(posture) for posture in q]]
    if not len(q):
        raise NoUsableResult(
            "no posture within the limits is clear: widen --box, or --no-clearance"
        )
    weight = _weight(robot, joint, q)
    told = load_model(robot, joint).parameters[:WEIGHT]
    if not np.any(weight):
        raise NoUsableResult("at rest no joint feels what is held there: the arm moves level only")
    kept = find_base_parameters(weight.reshape(-1, WEIGHT), told).columns
    gain, total, arm = _information(problem, q, weight[:, :, kept])
    taken: list[int] = []
    for _ in range(count):
        after = total + gain
        worth = np.linalg.slogdet(after)[1] - np.linalg.slogdet(after[:, :arm, :arm])[1]
        worth[taken] = -np.inf
        best = int(np.argmax(worth))
        taken.append(best)
        total = total + gain[best]
    return _short_way(q[taken])


def _information(
    problem: LoadProblem,
    q: Float[ndarray, "poses joints"],
    weight: Float[ndarray, "poses joints k"],
) -> tuple[Float[ndarray, "poses x x"], Float[ndarray, "x x"], int]:
    """What each posture tells of the arm and of the load's weight, and what is known before.

    Returns:
        Information of each posture, and that before all, of the arm in units of what is known of
        it, and how many of the parameters are the arm's.
    """
    if problem.covariance is None:
        raise ValueError("the problem of a load has a noise")
    arm = problem.arm_base.reduce(problem.model.columns(_at_rest(q)))
    seen = np.flatnonzero(np.any(arm != 0, axis=(0, 1)))
    root = np.linalg.cholesky(np.linalg.inv(problem.known)[np.ix_(seen, seen)])
    rows = np.concatenate([arm[:, :, seen] @ root, weight], axis=2)
    rows = rows / np.sqrt(problem.covariance)[:, None]
    gain = np.einsum("kjp,kjq->kpq", rows, rows)
    total = np.eye(rows.shape[2])
    load = slice(len(seen), None)
    total[load, load] *= RIDGE * np.trace(gain[:, load, load].mean(axis=0))
    return gain, total, len(seen)


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
    return load_model(robot, joint).columns(_at_rest(q))[:, :, :WEIGHT]


def _at_rest(q: Float[ndarray, "poses joints"]) -> Motion:
    still = np.zeros_like(q)
    return Motion(np.arange(len(q)) * 1.0, q, still, still)


def _short_way(q: Float[ndarray, "count joints"]) -> Float[ndarray, "count joints"]:
    """From the first posture always to the nearest that is left."""
    order, left = [0], list(range(1, len(q)))
    while left:
        nearest = min(left, key=lambda k: float(np.abs(q[k] - q[order[-1]]).max()))
        order.append(nearest)
        left.remove(nearest)
    return q[order]
