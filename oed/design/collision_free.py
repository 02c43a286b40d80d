"""The motion that tells most among those that keep the arm clear of itself and its walls.

The criterion is minimised with a price on every distance that is short. Distances are
linearised at the instants where they are short, or could soon be, and trusted within a step of
the motion at which that was done; steps that do not lower the sum of criterion and price are
taken back and shortened (Schulman et al. 2013, "Finding locally optimal, collision-free
trajectories with sequential convex optimization"). The price rises until no distance is short.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.design.clear_limits import NoClearRange, clear_limits
from oed.design.clearance import ClearanceCheck, prove_clearance
from oed.design.collision import Surroundings
from oed.design.constraints import TrustRegion
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.local_solution import LocalSettings, solve_near, violated
from oed.design.optimisers.result import EvaluationLog
from oed.design.problem import DesignProblem
from oed.design.trajectories import TrajectoryClass
from oed.errors import NoUsableResult

# At which distances are looked at: twenty in a period of the fastest harmonic of five; what is
# nearer between them is found by the proof, and those instants join.
INSTANTS = 200
AHEAD = 0.1  # [m] beyond what is wanted, within which a distance counts: an arm's largest step
# [m] beyond what is wanted, where the price begins: room for what lies between the instants.
BUFFER = 0.003
# [decades] at first, of a distance that is `BUFFER` short all the time: hitting one's way through
# is not worth it then, but a corner may be cut on the way out.
PRICE = 3.0
# Times the price, where it does not keep distances: a price is exact above the gain per distance
# (Nocedal and Wright, Numerical Optimization, section 17.2), which no number bounds for all arms.
DEARER = 10.0
# [rad or m] that a round may move: what a linear model of distances is good for is found by
# halving and growing, so that the first matters little; below the least one it moves by a degree.
FIRST_STEP, LARGEST_STEP, LEAST_STEP = 0.3, 0.6, 0.02
STUCK = 2  # rises of the price without a step in between: what bars the way is no longer the price
ROUNDS = 40  # twice what arms of six and seven joints took
LEAST_GAIN = (
    0.02  # [decades] of a round that is worth another at the same price: 0.1 % of an estimate
)
LOCAL = LocalSettings(iterations=25, constraint_instants=40)  # half converged: the model is local
ENOUGH = 5e-4  # [m] at the instants: twice what the proof leaves to rounding, and a little more
HALVINGS = 4  # of a range in which collisions are rare: to a sixteenth, a few degrees of a joint
DESCENTS = 4  # each looks at the instants, too, at which the last was nearer than it should be


class NoClearMotion(NoUsableResult):
    """No motion clear of collisions was found."""


@dataclass(frozen=True)
class ClearMotion:
    """A motion that keeps its distances at `INSTANTS` instants.

    Attributes:
        z: (size,) the motion.
        cost: Its exact criterion.
        rounds: Linearisations that were solved; 0 if the search began there.
        check: What is proven of its distances; None before that.
    """

    z: Float[ndarray, " size"]
    cost: float
    rounds: int
    check: ClearanceCheck | None = None


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of a class of motions, linearised at one motion.

    Attributes:
        trajectory: The class.
        t: (K,) instants [s].
        where: (C,) instant of each distance.
        slopes: (C, n) by the joints [m per rad or m].
        short: (C,) what each wants beyond slope . q [m]: it is short where this is above.
        spare: Least spare distance, exactly, of the motion itself [m].
    """

    trajectory: TrajectoryClass
    t: Float[ndarray, " samples"]
    where: Int[ndarray, " distances"]
    slopes: Float[ndarray, "distances joints"]
    short: Float[ndarray, " distances"]
    spare: float

    @classmethod
    def at(
        cls,
        trajectory: TrajectoryClass,
        z: Float[ndarray, " size"],
        surroundings: Surroundings,
        instants: Float[ndarray, " more"] | tuple[float, ...] = (),
    ) -> Distances:
        """Look at a motion, at further instants too [s]."""
        t = np.union1d(np.linspace(0.0, trajectory.horizon, INSTANTS), instants)
        found: list[tuple[int, ndarray, float]] = []
        least = AHEAD
        for k, posture in enumerate(trajectory.derivative(z, t, 0)):
            for near in surroundings.near(posture, AHEAD):
                spare = near.distance - surroundings.wanted(near.pair)
                least = min(least, spare)
                found.append((k, near.slope, float(near.slope @ posture) - spare))
        where, slopes, short = zip(*found, strict=True) if found else ((), (), ())
        slopes = np.array(slopes).reshape(-1, trajectory.joints)
        return cls(trajectory, t, np.array(where, dtype=int), slopes, np.array(short), least)

    def price(self, z: Float[ndarray, " size"], weight: float) -> tuple[float, ndarray]:
        """What short distances cost [decades], and the gradient by z.

        Of a distance that is short by x times `BUFFER`, beginning there, x^2, and 2x - 1 from
        x = 1: deep overlaps must not drown the criterion.
        """
        q = self.trajectory.derivative(z, self.t, 0)
        x = (self.short - (self.slopes * q[self.where]).sum(axis=1)) / BUFFER + 1.0
        x = np.maximum(x, 0.0)
        factor = weight / len(self.t)
        slope = -2 * factor / BUFFER * np.minimum(x, 1.0)[:, None] * self.slopes
        adjoint = np.zeros_like(q)
        np.add.at(adjoint, self.where, slope)
        value = factor * np.where(x < 1.0, x**2, 2 * x - 1).sum()
        return float(value), self.trajectory.pull_back(z, self.t, (adjoint,))


def find_clear_motion(
    problem: DesignProblem,
    z: Float[ndarray, " size"],
    surroundings: Surroundings,
    log: EvaluationLog,
    rng: np.random.Generator,
) -> ClearMotion:
    """The best motion, by local searches, that is proven to keep its distances.

    A motion that need not keep them is one beginning; unless it keeps them, the best motion
    within a range of positions in which collisions are rare is another. The search begins where
    criterion and price together are less, and at the other one if no way leads out of what that
    hits; it leaves the narrower range again. Where neither leads out, the range is halved about its
    clear centre, again and again: a small one is clear as its centre is.

    Args:
        problem: Any; of a class without an offset, without a second beginning.
        z: A motion within its limits, such as the best one without distances to keep.
        surroundings: What may be hit.
        log: Counts evaluations, and says when to stop; where nothing clear was found with its
            evaluations, more are made until the first motion that is.
        rng: Of the second beginning.

    Raises:
        NoClearPosture: If no posture is clear.
        NoClearMotion: If no motion is found.
    """
    for start in _beginnings(problem, z, surroundings, log, rng):
        found = _proven(problem, start, surroundings, log)
        if found is not None:
            return found
        if log.is_late:
            break
    in_time, more = (" in time", "allow more (--budget), ") if log.is_late else ("", "")
    raise NoClearMotion(
        f"no motion was found{in_time} that keeps the arm clear of itself and its box by "
        f"{1e3 * surroundings.clearance:g} mm: {more}ask for less (--clearance), or narrow the "
        f"limits of positions yourself{surroundings.mostly_short}"
    )


def _beginnings(
    problem: DesignProblem,
    z: Float[ndarray, " size"],
    surroundings: Surroundings,
    log: EvaluationLog,
    rng: np.random.Generator,
) -> Iterator[Float[ndarray, " size"]]:
    """Motions from which to search, the most promising first, each when it is asked for."""

    def toll(start: Float[ndarray, " size"]) -> float:
        seen = Distances.at(problem.trajectory, start, surroundings)
        return log.evaluate(problem.cost, start) + seen.price(start, PRICE)[0]

    is_clear = Distances.at(problem.trajectory, z, surroundings).spare >= ENOUGH
    # Without an offset a class fits no range but its own.
    if is_clear or log.is_late or not problem.trajectory.has_offset:
        yield z
        return
    try:
        room = clear_limits(problem.limits, surroundings, rng)
    except NoClearRange:
        yield z
        return

    def within(position: Float[ndarray, "joints 2"]) -> Float[ndarray, " size"]:
        limits = room.limits.with_(position=position)
        trajectory = problem.trajectory.with_limits(limits)
        narrow = dataclasses.replace(problem, trajectory=trajectory, limits=limits)
        found = optimise(narrow, log.half(), rng)
        log.count(found.evaluations)
        return found.z

    position, centre = room.limits.position, room.centre[:, None]
    yield from sorted((z, within(position)), key=toll)
    for _ in range(HALVINGS):
        position = (position + centre) / 2
        yield within(position)


def _proven(
    problem: DesignProblem,
    z: Float[ndarray, " size"],
    surroundings: Surroundings,
    log: EvaluationLog,
) -> ClearMotion | None:
    """Descend until what was found is proven between instants too; None if that fails."""
    instants = np.zeros(0)
    for _ in range(DESCENTS):
        found = descend(problem, z, surroundings, log, instants)
        if found is None:
            return None
        check = prove_clearance(surroundings, problem.trajectory, found.z)
        if check.is_kept:
            return dataclasses.replace(found, check=check)
        z, instants = found.z, np.union1d(instants, check.short)
    return None


def descend(
    problem: DesignProblem,
    z: Float[ndarray, " size"],
    surroundings: Surroundings,
    log: EvaluationLog,
    instants: Float[ndarray, " more"] | tuple[float, ...] = (),
) -> ClearMotion | None:
    """Lower criterion and price together from z; None if no motion on the way is clear.

    Args:
        problem: Of a class with an offset.
        z: A motion within its limits.
        surroundings: What may be hit.
        log: Counts evaluations, and says when to stop.
        instants: At which distances are looked at besides `INSTANTS` equally spaced ones [s].
    """
    seen = Distances.at(problem.trajectory, z, surroundings, instants)
    cost, peaks = log.evaluate(problem.cost, z), np.zeros(0)
    weight, step, rounds, stuck = PRICE, FIRST_STEP, 0, 0
    best = (np.array(z), cost) if seen.spare >= ENOUGH else None
    while rounds < ROUNDS and stuck < STUCK:
        if log.is_late or (best is not None and log.is_spent):
            break
        rounds += 1
        near = solve_near(
            problem,
            z,
            log,
            LOCAL,
            trust=TrustRegion(z, step),
            penalty=partial(seen.price, weight=weight),
            dearer=weight / PRICE,
            peaks=peaks,
            may_exceed=best is None,
        )
        peaks = np.union1d(peaks, violated(problem, near))
        candidate = problem.repair(near)
        new_cost = log.evaluate(problem.cost, candidate)
        new = Distances.at(problem.trajectory, candidate, surroundings, instants)
        gain = cost + seen.price(z, weight)[0] - new_cost - new.price(candidate, weight)[0]
        if new.spare >= ENOUGH and (best is None or new_cost < best[1]):
            best = candidate, new_cost
        if gain > 0.0:
            z, cost, seen, stuck = candidate, new_cost, new, 0
            step = min(1.5 * step, LARGEST_STEP)
        else:
            step /= 3
        if step < LEAST_STEP or 0.0 < gain < LEAST_GAIN:
            if seen.spare >= ENOUGH:
                break
            weight, step, stuck = DEARER * weight, FIRST_STEP, stuck + 1
    return None if best is None else ClearMotion(*best, rounds)
