"""A motion moved away from collisions, as little as that takes.

Distances are linearised at the instants where they are short, which makes them linear in the
coefficients of a Fourier motion, as its limits are: the nearest motion that keeps both is a
quadratic program. Instants are exchanged until none is short. Where that does not end, the
motion shrinks towards a posture in which nothing touches.
"""

from __future__ import annotations

from dataclasses import dataclass

import clarabel
import numpy as np
import scipy.sparse
from jaxtyping import Float
from numpy import ndarray

from oed.design.collision import Surroundings
from oed.design.constraints import LimitConstraints
from oed.design.problem import DesignProblem
from oed.errors import NoUsableResult

AHEAD = 0.03  # [m] beyond what is wanted, within which a distance joins the program
ROUNDS = 15
INSTANTS = 400  # looked at in each round
LIMIT_INSTANTS = 80  # at which the program holds the limits; repair brings in the rest
STEP = 0.25  # [rad or m] most that a position may move in a round: distances are linearised
SHORTFALL = 1e3  # price of a distance that stays short, per metre, against squared change
SHRINKING = 0.95  # of the motion, each time, where the program does not end
SMALLEST = 0.01  # share of a motion below which it is none


class NoClearMotion(NoUsableResult):
    """No motion clear of collisions was found."""


@dataclass(frozen=True)
class ClearMotion:
    """A motion without short distances.

    Attributes:
        z: (size,) the motion.
        rounds: Quadratic programs solved.
        factor: By which the motion was shrunk in the end; 1 where the programs sufficed.
    """

    z: Float[ndarray, " size"]
    rounds: int
    factor: float


@dataclass(frozen=True)
class _Short:
    """A distance to be kept at an instant: slope . q >= bound."""

    instant: int
    slope: Float[ndarray, " joints"]
    bound: float


def avoid_collision(
    problem: DesignProblem,
    z: Float[ndarray, " size"],
    surroundings: Surroundings,
    centre: Float[ndarray, " joints"],
) -> ClearMotion:
    """The nearest motion, by linearisation, whose distances are not short at many instants.

    Args:
        problem: Of a class that is linear in z.
        z: A motion within its limits.
        surroundings: What may be hit.
        centre: (n,) a posture that is clear.

    Raises:
        ValueError: If the class is not linear.
        NoClearMotion: If even a motion close to the centre is too near to something.
    """
    if not problem.trajectory.is_linear:
        raise ValueError("collisions can be avoided by classes linear in their coefficients only")
    t = np.linspace(0.0, problem.trajectory.horizon, INSTANTS)
    for number in range(ROUNDS + 1):
        q = problem.trajectory.motion(z, t).q
        short, is_clear = _short_distances(surroundings, q)
        if is_clear:
            return ClearMotion(z, number, 1.0)
        if number < ROUNDS:
            z = problem.repair(_nearest(problem, z, t, short))
    return _shrunk(problem, z, t, surroundings, centre)


def _short_distances(surroundings: Surroundings, q: ndarray) -> tuple[list[_Short], bool]:
    """Distances that are short or nearly so, and whether none is truly short."""
    found, is_clear = [], True
    for k, posture in enumerate(q):
        for near in surroundings.near(posture):
            wanted = surroundings.wanted(near.pair)
            # Half of what is asked for counts as clear, so that linearisation need not be exact.
            is_clear &= near.distance >= wanted / 2
            if near.distance < wanted + AHEAD and np.any(near.slope):
                bound = wanted - near.distance + near.slope @ posture
                found.append(_Short(k, near.slope, float(bound)))
    return found, is_clear


def _nearest(
    problem: DesignProblem, z: ndarray, t: ndarray, short: list[_Short]
) -> Float[ndarray, " size"]:
    """The motion with the least squared change, in units of the box, that is not short."""
    half = np.diff(problem.trajectory.bounds, axis=1)[:, 0] / 2
    change = _least_change(*_inequalities(problem, z, t, short, half), len(z), len(short))
    return z + half * change if np.isfinite(change).all() else z


def _inequalities(
    problem: DesignProblem, z: ndarray, t: ndarray, short: list[_Short], half: ndarray
) -> tuple[scipy.sparse.csc_matrix, ndarray]:
    """A and b of A x <= b: limits, most of a step, distances, and shortfalls that are none.

    Unknowns: u, the change in half widths of the box, and one shortfall for each distance.
    """
    trajectory = problem.trajectory
    size, count = len(z), len(short)
    grid = np.linspace(0.0, trajectory.horizon, LIMIT_INSTANTS)
    limits = LimitConstraints(trajectory, problem.limits, grid)
    jacobian = limits.jacobian(z) @ scipy.sparse.diags(half)
    at, values = limits.values(z), trajectory.motion(z, t).q
    moved = _by_position(problem, z, t)
    rows = np.stack([s.slope @ moved[s.instant] for s in short]) * half
    room = np.array([s.slope @ values[s.instant] - s.bound for s in short])
    position = _by_position(problem, z, grid).reshape(-1, size) * half
    blank = scipy.sparse.csc_matrix((jacobian.shape[0], count))
    none = scipy.sparse.csc_matrix((len(position), count))
    blocks = [
        scipy.sparse.hstack([jacobian, blank]),
        scipy.sparse.hstack([-jacobian, blank]),
        scipy.sparse.hstack([position, none]),
        scipy.sparse.hstack([-position, none]),
        scipy.sparse.hstack([-rows, -scipy.sparse.identity(count)]),
        scipy.sparse.hstack(
            [scipy.sparse.csc_matrix((count, size)), -scipy.sparse.identity(count)]
        ),
    ]
    step = np.full(len(position), STEP)
    right = [limits.upper - at, at - limits.lower, step, step, room, np.zeros(count)]
    bounds = np.concatenate(right)
    kept = np.isfinite(bounds)
    return scipy.sparse.vstack(blocks).tocsc()[np.flatnonzero(kept)], bounds[kept]


def _least_change(
    matrix: scipy.sparse.csc_matrix, bounds: ndarray, size: int, count: int
) -> Float[ndarray, " size"]:
    """The least `size` changes in squares, and `count` shortfalls at their price, with A x <= b."""
    cost = scipy.sparse.block_diag(
        [scipy.sparse.identity(size), scipy.sparse.csc_matrix((count, count))]
    )
    price = np.concatenate([np.zeros(size), np.full(count, SHORTFALL)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    cones = [clarabel.NonnegativeConeT(len(bounds))]
    solver = clarabel.DefaultSolver(cost.tocsc(), price, matrix.tocsc(), bounds, cones, settings)
    return np.array(solver.solve().x)[:size]


def _by_position(
    problem: DesignProblem, z: ndarray, t: ndarray
) -> Float[ndarray, "samples joints size"]:
    """Derivative of every joint's position by all variables."""
    trajectory = problem.trajectory
    own = trajectory.sensitivity(z, t, 0)
    result = np.zeros((len(t), trajectory.joints, trajectory.size))
    for joint, columns in enumerate(trajectory.variables):
        result[:, joint, columns] = own[:, joint]
    return result


def _shrunk(
    problem: DesignProblem, z: ndarray, t: ndarray, surroundings: Surroundings, goal: ndarray
) -> ClearMotion:
    """The motion brought towards a clear posture in small steps until it is clear."""
    trajectory, factor = problem.trajectory, 1.0
    centre = trajectory.centre(z)
    while factor > SMALLEST:
        factor *= SHRINKING
        smaller = trajectory.shrink(z, np.full(trajectory.joints, factor))
        smaller = trajectory.shift(smaller, (1 - factor) * (goal - centre))
        if all(surroundings.is_clear(q) for q in trajectory.motion(smaller, t).q):
            return ClearMotion(smaller, ROUNDS, factor)
    raise NoClearMotion("no motion clear of collisions was found, however small")
