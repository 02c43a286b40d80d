"""Moves from one motion to a neighbouring one, from which a local solver may find a better.

Moves of the whole vector serve every class; a class adds those that only it knows.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.limits import fill
from oed.design.optimisers.starts import mixed_start
from oed.design.problem import DesignProblem

Move = Callable[[DesignProblem, Float[ndarray, " size"], np.random.Generator], ndarray]

SHIFT_SIZES = (0.003, 0.1)  # least and greatest standard deviation, relative to the box
SHIFTED_VARIABLES = 0.3  # share of the variables that a shift moves: some stay as they are; assumed


def neighbour(
    problem: DesignProblem, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """A random move of z, each joint then scaled until it touches one of its limits."""
    moves = [*(partial(move, problem) for move in GENERAL), *problem.trajectory.moves]
    moved = moves[rng.integers(len(moves))](np.array(z), rng)
    clipped = problem.trajectory.clip(moved)
    return problem.quick_repair(fill(problem.trajectory, clipped, problem.limits))


def shift(
    problem: DesignProblem, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """Some variables moved a little, or more."""
    size = np.exp(rng.uniform(*np.log(SHIFT_SIZES)))
    is_moved = rng.random(problem.size) < SHIFTED_VARIABLES
    width = np.diff(problem.trajectory.bounds, axis=1)[:, 0]
    return z + size * width * is_moved * rng.standard_normal(problem.size)


def renew_joint(
    problem: DesignProblem, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """One joint's motion drawn afresh."""
    own = problem.trajectory.variables[rng.integers(problem.trajectory.joints)]
    z[own] = mixed_start(problem, rng)[own]
    return z


GENERAL: tuple[Move, ...] = (shift, renew_joint)
