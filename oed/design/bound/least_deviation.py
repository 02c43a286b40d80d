"""How well any motion within the limits could tell one parameter of a load: a bound on its deviation.

What a motion tells is a sum over the states that it visits, so its information is that of a distribution over
states, and the variance of a parameter is convex in that (Kiefer and Wolfowitz 1960, "The equivalence of two
extremum problems"). The best distribution bounds every motion from below, the more generously as it need not
belong to any: states are taken as they come, with no way from one to the next. For a distribution with
variance V and gains g_x, by which a sample of state x would lower it, no distribution has less than
V - (max_x g_x - mean g). The maximum is searched for, not proven.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.load_problem import LoadProblem
from oed.dynamics.motion import Motion

# Velocities, as shares of the limit, at which friction's sign is told without its size.
SLOW = (0.01, 0.1)
LEAST_WEIGHT = 1e-7  # of the largest: states beneath are dropped
NEW_SHARE = 0.1  # of the weight, that new states begin with
LEAST_STEP, LARGEST_STEP = 0.003, 0.5  # of a range, in the search for states
MOVED = 0.3  # share of a state's numbers that a step moves
LEAST_GAIN = 1e-12  # of the largest, so that no weight dies at once


@dataclass(frozen=True)
class DeviationSearch:
    """How hard to look.

    Attributes:
        first: States to begin with.
        rounds: Of weighing the states, and looking for more.
        steps: Of weighing, each round.
        drawn: States drawn each round, of which the best `kept` are improved.
        kept: States that are added each round.
        climbs: Random steps by which each of these is improved.
    """

    first: int = 1500
    rounds: int = 6
    steps: int = 80
    drawn: int = 4000
    kept: int = 300
    climbs: int = 150


@dataclass(frozen=True)
class LeastDeviation:
    """Between which numbers the least standard deviation of a parameter lies.

    Attributes:
        lower: No distribution of states has less, as far as was looked.
        reached: By the best distribution that was found.
    """

    lower: float
    reached: float


@dataclass(frozen=True)
class _States:
    q: Float[ndarray, "states joints"]
    dq: Float[ndarray, "states joints"]
    ddq: Float[ndarray, "states joints"]

    def chosen(self, where: ndarray) -> _States:
        return _States(self.q[where], self.dq[where], self.ddq[where])

    def joined(self, other: _States) -> _States:
        pairs = ((self.q, other.q), (self.dq, other.dq), (self.ddq, other.ddq))
        return _States(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True)
class _Asked:
    """Which parameter is asked for, how many samples a motion has, and what is known before."""

    known: Float[ndarray, "x x"]
    parameter: int
    count: int

    def influence(
        self, rows: Float[ndarray, "states joints x"], weights: Float[ndarray, " states"]
    ) -> tuple[Float[ndarray, " x"], float]:
        """Column of the covariance that belongs to the parameter, and its variance."""
        white = (rows * np.sqrt(self.count * weights)[:, None, None]).reshape(-1, rows.shape[2])
        unit = np.zeros(rows.shape[2])
        unit[self.parameter] = 1.0
        across = np.linalg.solve(self.known + white.T @ white, unit)
        return across, float(across[self.parameter])


def least_deviation(
    problem: LoadProblem,
    parameter: int,
    rng: np.random.Generator,
    search: DeviationSearch | None = None,
) -> LeastDeviation:
    """Bound what any motion of a problem's instants could tell of one base parameter of the load.

    Args:
        problem: With finite limits, and one variance a joint.
        parameter: Index of the base parameter.
        rng: Of the states looked at.
        search: How hard to look.
    """
    search = search or DeviationSearch()
    unit, count = _units(problem), len(problem.instants)
    known = np.zeros((len(unit), len(unit)))
    known[: len(problem.known), : len(problem.known)] = problem.known
    asked = _Asked(known * np.outer(unit, unit), len(problem.known) + parameter, count)
    states = _drawn(problem, search.first, rng)
    rows = _rows(problem, states)
    weights = np.full(search.first, 1 / search.first)
    lower, reached = 0.0, np.inf
    for _ in range(search.rounds):
        weights = _weighed(rows, weights, asked, search.steps)
        across, variance = asked.influence(rows, weights)
        gains = count * np.sum((rows @ across) ** 2, axis=1)
        more, most = _better_states(problem, across, rng, search)
        excess = max(count * most, float(gains.max())) - float(weights @ gains)
        lower, reached = max(lower, variance - excess), min(reached, variance)
        kept = weights > LEAST_WEIGHT * weights.max()
        states = states.chosen(kept).joined(more)
        rows = _rows(problem, states)
        old = (1 - NEW_SHARE) * weights[kept] / weights[kept].sum()
        weights = np.append(old, np.full(len(more.q), NEW_SHARE / len(more.q)))
    return LeastDeviation(*(float(unit[asked.parameter] * np.sqrt(x)) for x in (lower, reached)))


def _weighed(
    rows: Float[ndarray, "states joints x"],
    weights: Float[ndarray, " states"],
    asked: _Asked,
    steps: int,
) -> Float[ndarray, " states"]:
    """Weights after steps of the multiplicative algorithm (Silvey, Titterington and Torsney 1978)."""
    for _ in range(steps):
        across, _ = asked.influence(rows, weights)
        gains = np.sum((rows @ across) ** 2, axis=1)
        weights = weights * np.sqrt(np.maximum(gains, LEAST_GAIN * gains.max()))
        weights = weights / weights.sum()
    return weights


def _drawn(problem: LoadProblem, count: int, rng: np.random.Generator) -> _States:
    """Random postures; speeds of every size; accelerations at their limits or none."""
    limits, shape = problem.limits, (count, problem.model.robot.n)
    q = rng.uniform(limits.position[:, 0], limits.position[:, 1], shape)
    lowest, highest = limits.velocity.T
    special = rng.choice([-1.0, 1.0, *SLOW, *(-x for x in SLOW)], shape)
    edge = np.where(special > 0, highest, -lowest) * special
    dq = np.where(rng.random(shape) < 0.5, rng.uniform(lowest, highest, shape), edge)
    side = rng.integers(0, 2, shape)
    ddq = np.take_along_axis(limits.acceleration.T, side, axis=0)
    return _States(q, dq, np.where(rng.random(shape) < 0.2, 0.0, ddq))


def _rows(problem: LoadProblem, states: _States) -> Float[ndarray, "states joints x"]:
    """Of each state, in units of the noise and of the scaling."""
    motion = Motion(np.arange(len(states.q)) * 1.0, states.q, states.dq, states.ddq)
    rows = problem.regressor.dense(problem.regressor.entries(motion))
    if problem.covariance is not None:
        rows = rows / np.sqrt(problem.covariance)[:, None]
    return rows * _units(problem)


def _units(problem: LoadProblem) -> Float[ndarray, " x"]:
    """In which numbers are near one: what is known of the arm, and the load's own."""
    load = np.ones(len(problem.base)) if problem.scaling is None else problem.scaling
    return np.append(1 / np.sqrt(np.diag(problem.known)), load)


def _better_states(
    problem: LoadProblem,
    across: Float[ndarray, " x"],
    rng: np.random.Generator,
    search: DeviationSearch,
) -> tuple[_States, float]:
    """States that would lower the variance most, by random local search, and by how much a sample."""

    def gain(states: _States) -> Float[ndarray, " states"]:
        return np.sum((_rows(problem, states) @ across) ** 2, axis=1)

    limits = problem.limits
    states = _drawn(problem, search.drawn, rng)
    gains = gain(states)
    best = np.argsort(-gains)[: search.kept]
    states, gains = states.chosen(best), gains[best]
    shape = states.q.shape
    for _ in range(search.climbs):
        size = np.exp(rng.uniform(*np.log([LEAST_STEP, LARGEST_STEP])))
        step = size * (rng.random(shape) < MOVED) * rng.standard_normal(shape)
        q = np.clip(states.q + step * np.ptp(limits.position, axis=1), *limits.position.T)
        step = size * (rng.random(shape) < MOVED) * rng.standard_normal(shape)
        dq = np.clip(states.dq + step * np.ptp(limits.velocity, axis=1), *limits.velocity.T)
        redrawn = rng.random(shape) < MOVED / 3
        tried = _States(q, dq, np.where(redrawn, _drawn(problem, len(q), rng).ddq, states.ddq))
        value = gain(tried)
        better = (value > gains)[:, None]
        states = _States(
            np.where(better, tried.q, states.q),
            np.where(better, tried.dq, states.dq),
            np.where(better, tried.ddq, states.ddq),
        )
        gains = np.maximum(gains, value)
    return states, float(gains.max())
