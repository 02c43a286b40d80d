"""Proof of how near a motion brings the arm to itself and to its walls, between instants too.

While each joint moves by at most dq_j, no distance changes by more than the sum of dq_j times
the reach of that joint. A stretch of time about an instant is proven clear where the distances
at that instant exceed what the arm can move within it; other stretches are split.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.counted import counted
from oed.design.collision import FAR, Surroundings, is_wall
from oed.design.extrema import FIRST_INTERVALS, first_intervals, split_intervals
from oed.design.posed_shapes import Pair
from oed.design.status import LimitStatus, Standing
from oed.design.trajectories import TrajectoryClass

TOLERANCE = 1e-3  # [m] between proven and attained distance, where that is not kept
MOST_INSTANTS = 20_000  # of a proof: some ten seconds
ROUNDING = 2e-4  # [m] by which Drake's distance of two hulls may be off


@dataclass(frozen=True)
class Nearest:
    """The least distance of one kind of pair, and what is proven of all of that kind.

    Attributes:
        least: At the instants looked at [m]; negative where two overlap or a wall is passed.
            None where nothing came within `FAR`.
        pair: Names of those two.
        time: When [s].
        spare: Proven for all t: no pair is nearer than what it should keep and this [m];
            negative where that is not kept.
    """

    least: float | None
    pair: Pair | None
    time: float | None
    spare: float


@dataclass(frozen=True)
class ClearanceCheck:
    """What a check found.

    Attributes:
        wanted: Distance that links should keep [m].
        bodies: Of two links; None where that was not checked.
        walls: Of a body's origin and a wall of the box; None likewise.
        instants: Number of instants looked at.
        note: What could not be checked, or is not held to `wanted`.
        missing: Meshes of collision shapes that were not found: the check says nothing of them.
        unjudged: What else it says nothing of, in words.
        nearer: Pairs that are held to less than `wanted`, and to what, in words.
        short: The worst instant of each stretch of time that is not proven [s].
    """

    wanted: float
    bodies: Nearest | None
    walls: Nearest | None
    instants: int
    note: str
    missing: tuple[str, ...] = ()
    unjudged: tuple[str, ...] = ()
    nearer: str = ""
    short: tuple[float, ...] = ()

    @classmethod
    def not_made(cls, reason: str, missing: tuple[str, ...] = ()) -> ClearanceCheck:
        """Of nothing, and why."""
        return cls(0.0, None, None, 0, reason, missing)

    @property
    def is_kept(self) -> bool:
        """Whether every distance that could be checked is proven to be kept."""
        return all(found is None or found.spare >= 0.0 for found in (self.bodies, self.walls))


def prove_clearance(
    surroundings: Surroundings, trajectory: TrajectoryClass, z: Float[ndarray, " size"]
) -> ClearanceCheck:
    """Bound all distances from below, for all t in the horizon.

    Args:
        surroundings: What may be hit.
        trajectory: The class.
        z: The motion.
    """
    if not surroundings.has_shapes and surroundings.box is None:
        return ClearanceCheck.not_made(surroundings.note, surroundings.missing)
    fastest_change = trajectory.derivative_bound(z, 2)
    middle, half = first_intervals(trajectory)
    kinds, instants = (_Kind(surroundings, of_walls) for of_walls in (False, True)), 0
    bodies, walls = kinds
    while len(middle):
        q, speed = (trajectory.derivative(z, middle, order) for order in range(2))
        moves = np.abs(speed) * half[:, None] + fastest_change * half[:, None] ** 2 / 2
        for t, posture, move in zip(middle, q, moves, strict=True):
            # What the arm cannot reach within the stretch need not be asked for.
            furthest = surroundings.clearance + surroundings.drift(None) @ move + 2 * ROUNDING
            ahead = min(FAR, furthest)
            distances = surroundings.distances(posture, ahead)
            bodies.look(distances, float(t), move, ahead)
            walls.look(distances, float(t), move, ahead)
        instants += len(middle)
        is_open = bodies.is_open | walls.is_open
        if instants + 4 * is_open.sum() > MOST_INSTANTS:
            is_open[:] = False
        bodies.close(~is_open)
        walls.close(~is_open)
        middle, half = split_intervals(middle[is_open], half[is_open])
    return ClearanceCheck(
        surroundings.clearance,
        bodies.found if surroundings.has_shapes else None,
        None if surroundings.box is None else walls.found,
        instants,
        surroundings.note,
        surroundings.missing,
        surroundings.unjudged,
        surroundings.nearer,
        worst_of_each(bodies.short + walls.short, trajectory.horizon / FIRST_INTERVALS),
    )


class _Kind:
    """Pairs of bodies, or bodies and walls, while instants are looked at."""

    def __init__(self, surroundings: Surroundings, of_walls: bool) -> None:
        self._surroundings, self._of_walls = surroundings, of_walls
        self._near: tuple[float, Pair | None, float | None] = (FAR, None, None)
        self._spare, self._proven = np.inf, np.inf
        self._bounds: list[float] = []
        self._times: list[float] = []
        self.short: list[tuple[float, float]] = []  # (instant, what is proven) where below zero

    def look(self, distances: dict[Pair, float], t: float, move: ndarray, ahead: float) -> None:
        """Note what is nearer than `ahead` at an instant, and what is proven about it."""
        surroundings = self._surroundings
        bound = ahead - surroundings.clearance - surroundings.drift(None) @ move - ROUNDING
        for pair, distance in distances.items():
            if is_wall(pair) != self._of_walls:
                continue
            if distance < self._near[0]:
                self._near = (distance, pair, t)
            spare = distance - surroundings.wanted(pair)
            self._spare = min(self._spare, spare)
            bound = min(bound, spare - surroundings.drift(pair) @ move - ROUNDING)
        self._bounds.append(float(bound))
        self._times.append(t)

    @property
    def is_open(self) -> Bool[ndarray, " stretches"]:
        """Stretches that must be split before anything is proven of them."""
        enough = 0.0 if self._spare >= ROUNDING else self._spare - TOLERANCE
        return np.array(self._bounds) < enough

    def close(self, closed: Bool[ndarray, " stretches"]) -> None:
        """Keep what is proven of the stretches that are not split."""
        bounds, times = np.array(self._bounds)[closed], np.array(self._times)[closed]
        self._proven = min([self._proven, *bounds])
        self.short += zip(times[bounds < 0.0], bounds[bounds < 0.0], strict=True)
        self._bounds, self._times = [], []

    @property
    def found(self) -> Nearest:
        """What came out."""
        distance, pair, time = self._near
        return Nearest(None if pair is None else distance, pair, time, float(self._proven))


def worst_of_each(found: list[tuple[float, float]], stretch: float) -> tuple[float, ...]:
    """Of instants with what is proven there, the one with least in each stretch of time [s]."""
    worst: dict[int, tuple[float, float]] = {}
    for t, bound in found:
        place = int(t // stretch)
        if place not in worst or bound < worst[place][1]:
            worst[place] = (float(t), bound)
    return tuple(sorted(t for t, _ in worst.values()))


def clearance_status(
    check: ClearanceCheck, *, is_wanted: bool, is_asked: bool, has_box: bool
) -> tuple[LimitStatus, ...]:
    """What a check says of the arm's distance to itself, and to its box.

    Args:
        check: Of the motion.
        is_wanted: Whether the motion is to be clear of the arm itself.
        is_asked: Whether the user asked for that in words, so that "not checked" will not do.
        has_box: Whether there is a box to be kept.
    """
    standing, evidence = _of_bodies(check, is_wanted)
    bodies = LimitStatus("clear of itself", standing, evidence, is_demanded=is_asked)
    if not has_box:
        return (bodies,)
    if check.walls is None:
        return bodies, LimitStatus("the box", "not checked", check.note, is_demanded=True)
    if check.walls.spare < 0.0:
        return bodies, LimitStatus("the box", "not kept", _shortfall(check.walls, check.wanted))
    return bodies, LimitStatus("the box", "proven")


def _of_bodies(check: ClearanceCheck, is_wanted: bool) -> tuple[Standing, str]:
    wanted = f"{1e3 * check.wanted:g} mm"
    wanted += f" ({check.nearer}, too close by design)" if check.nearer else ""
    if check.bodies is not None and check.bodies.spare < 0.0:
        return ("not kept" if is_wanted else "given up"), _shortfall(check.bodies, check.wanted)
    unknown = list(check.unjudged)
    if check.missing:
        names = ", ".join(check.missing)
        lost = counted(len(check.missing), "collision mesh is", "collision meshes are")
        unknown.append(f"{lost} not found ({names}): name --package NAME=DIR")
    if unknown and check.bodies is not None:
        unknown.append(f"all else keeps {wanted}")
    if unknown:
        return "not checked", "; ".join(unknown)
    if check.bodies is None:
        return "not checked", check.note.removeprefix("not checked: ")
    return "proven", f"by {wanted}" if check.wanted > 0.0 else ""


def _shortfall(nearest: Nearest, wanted: float) -> str:
    if nearest.least is None or nearest.pair is None:  # too fast to be proven
        return f"not proven to keep {1e3 * wanted:g} mm between instants"
    pair, distance = " and ".join(nearest.pair), 1e3 * nearest.least
    if nearest.least <= 0.0:
        what = "beyond by" if is_wall(nearest.pair) else "overlap by"
        return f"{pair} {what} {-distance:.1f} mm at {nearest.time:.2f} s"
    return f"{pair} come within {distance:.1f} mm at {nearest.time:.2f} s"
