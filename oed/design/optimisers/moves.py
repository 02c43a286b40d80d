"""Moves from one motion to a neighbouring one, from which a local solver may find a better.

Moves of the whole vector serve every class. Those of single terms are for sums of sines with
free frequencies: their local optima differ in what each sine is there for, and two sines of
nearly one frequency make a single one whose amplitude and phase change slowly.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.limits import fill
from oed.design.optimisers.starts import mixed_start
from oed.design.problem import DesignProblem
from oed.design.trajectories import HarmonicClass

Move = Callable[[DesignProblem, Float[ndarray, " size"], np.random.Generator], ndarray]

SHIFT_SIZES = (0.003, 0.1)  # least and greatest standard deviation, relative to the box
SHIFTED_VARIABLES = 0.3  # share of the variables that a shift moves
RELATIVE_SPLIT = 0.1  # standard deviation of the ratio of two near frequencies
OVERTONES = (1 / 3, 1 / 2, 2.0, 3.0, 5.0)  # ratios of a term's frequency to another's
OVERTONE_STRENGTH = 0.3  # greatest acceleration of an overtone, relative to its root's


def neighbour(
    problem: DesignProblem, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """A random move of z, each joint then scaled until it touches one of its limits."""
    moves = GENERAL
    if isinstance(problem.trajectory, HarmonicClass) and problem.trajectory.terms > 1:
        moves = GENERAL + OF_TERMS
    moved = moves[rng.integers(len(moves))](problem, np.array(z), rng)
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


def renew_term(
    problem: DesignProblem, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """One term with another frequency and amplitude."""
    trajectory = _sines(problem)
    a, omega = _terms(trajectory, rng)
    z[a[0]] = rng.standard_normal() * trajectory.amplitude_bound.max() / 8
    z[omega[0]] = trajectory.draw(rng)[omega[0]]
    return z


def split_term(
    problem: DesignProblem, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """One term's place taken by a part of another, at nearly that one's frequency."""
    trajectory = _sines(problem)
    a, omega = _terms(trajectory, rng)
    part = rng.standard_normal() * trajectory.amplitude_bound.max() / 4
    z[omega[0]] = z[omega[1]] * np.exp(RELATIVE_SPLIT * rng.standard_normal())
    z[a[0]] = -part
    z[a[1]] += part
    return z


def overtone(
    problem: DesignProblem, z: Float[ndarray, " size"], rng: np.random.Generator
) -> Float[ndarray, " size"]:
    """One term turned into an overtone, or undertone, of another."""
    a, omega = _terms(_sines(problem), rng)
    ratio = rng.choice(OVERTONES)
    z[omega[0]] = ratio * z[omega[1]]
    z[a[0]] = z[a[1]] / ratio**2 * rng.uniform(-OVERTONE_STRENGTH, OVERTONE_STRENGTH)
    return z


GENERAL: tuple[Move, ...] = (shift, renew_joint)
OF_TERMS: tuple[Move, ...] = (renew_term, split_term, overtone)


def _sines(problem: DesignProblem) -> HarmonicClass:
    """The class of motions, which must be one of single terms."""
    if not isinstance(problem.trajectory, HarmonicClass):
        raise TypeError(f"motions of class {problem.trajectory.name} have no terms to move")
    return problem.trajectory


def _terms(trajectory: HarmonicClass, rng: np.random.Generator) -> tuple[ndarray, ndarray]:
    """Where the amplitudes and frequencies of one joint stand in z, terms in random order."""
    own = trajectory.variables[rng.integers(trajectory.joints)].reshape(2, trajectory.terms)
    a, omega = own[:, rng.permutation(trajectory.terms)]
    return a, omega
