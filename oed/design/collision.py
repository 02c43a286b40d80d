"""How near an arm is to itself, and to the walls of a box, in a posture."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.posed_shapes import Nearness, Pair, PosedShapes
from oed.design.poses import Poses
from oed.robot import Robot

# [m] beyond which a distance is not asked for: the tip of an arm at 3 m/s, twice what most are
# allowed, comes this far in one of the first stretches of time that a proof looks at, 0.1 s.
FAR = 0.3
# [m] between links: where MoveIt Servo begins to slow down for self-collision
# (`self_collision_proximity_threshold`).
CLEARANCE = 0.01
# Random ones that tell which links cannot keep it: so many tell a share of 0.95 within 0.015, one
# standard deviation.
POSTURES = 200
# Of postures in which links overlap that always do (MoveIt Setup Assistant's
# `min_collision_fraction`).
ALWAYS = 0.95
OFTEN = (
    0.5  # share of postures, above which a pair by itself explains that no motion is clear: most
)
WORST = 3  # pairs, or links, in a message
WALLS = ("x", "y", "z")


class Surroundings:
    """A robot's shapes and the walls of its box, posed at will.

    Judged are all pairs of links that a joint of the design moves against each other, but two
    kinds: links that one joint of the file connects (Drake leaves these out; the limits of that
    joint keep them apart), and links that overlap in nearly all random postures. A pair that is
    mostly nearer than the clearance, such as two links of a compact wrist, should keep half of
    what it has at its furthest.

    Args:
        robot: Loaded from a file, with finite position limits.
        box: Lower and upper bound of x, y, z in the base frame [m], for the origins of the
            bodies; None for no box.
        clearance: Distance that links should keep [m].
        walls_only: Whether links may touch each other, so that only the box counts.

    Raises:
        ValueError: If a position is not limited.
        RobotError: If the robot has no file, or the file cannot be read.
    """

    def __init__(
        self,
        robot: Robot,
        box: Float[ndarray, "3 2"] | None = None,
        clearance: float = CLEARANCE,
        *,
        walls_only: bool = False,
    ) -> None:
        if not np.isfinite(robot.limits.position).all():
            raise ValueError("a clearance check needs finite position limits of every joint")
        self._shapes = PosedShapes(robot)
        self.box, self.clearance = box, clearance
        self.has_shapes = self._shapes.count > 0 and not walls_only
        self.missing = self._shapes.missing
        self.turns = ~self._shapes.is_slide  # (n,) of each joint
        self._reach = self._shapes.reaches(np.abs(robot.limits.position).max(axis=1))
        self._overlapping: frozenset[Pair] = frozenset()
        self._tight: dict[Pair, float] = {}
        self._short: dict[Pair, float] = {}
        self._drifts: dict[Pair, Float[ndarray, " joints"]] = {}
        self._judge(robot)
        lacking = () if self.has_shapes else ("no shapes to check for collision",)
        self.unjudged = self._unjudged()
        near = f"too close by design, so half of the most that they part: {self.nearer}"
        exceptions = (
            f"not judged: {', '.join(self.unjudged)}" if self.unjudged else "",
            near if self.nearer else "",
        )
        self.note = "; ".join(filter(None, (self._shapes.note, *lacking, *exceptions)))

    def near(self, q: Float[ndarray, " joints"], ahead: float = FAR) -> list[Nearness]:
        """All pairs within a distance in a posture, each once, and all bodies near a wall.

        Args:
            q: The posture.
            ahead: The distance [m].
        """
        between = self._shapes.near(q, ahead) if self.has_shapes else []
        return [*between, *self._near_walls(q, ahead)]

    def distances(self, q: Float[ndarray, " joints"], ahead: float = FAR) -> dict[Pair, float]:
        """As `near`, without the slopes [m]."""
        between: dict[Pair, float] = {}
        if self.has_shapes:
            between = self._shapes.distances(q, ahead)
        return between | self._wall_distances(q, ahead)

    def wanted(self, pair: Pair) -> float:
        """The distance that a pair should keep [m]."""
        return self._tight.get(pair, self.clearance)

    def spare(self, q: Float[ndarray, " joints"], ahead: float = FAR) -> float:
        """What the tightest pair has beyond the distance that it should keep [m].

        Args:
            q: The posture.
            ahead: Beyond which a distance is not asked for [m], at least the clearance.
        """
        distances = self.distances(q, ahead).items()
        return min((d - self.wanted(pair) for pair, d in distances), default=ahead - self.clearance)

    def is_clear(self, q: Float[ndarray, " joints"]) -> bool:
        """Whether every pair keeps the distance that it should, in a posture."""
        return self.spare(q, self.clearance) >= 0.0

    def drift(self, pair: Pair | None) -> Float[ndarray, " joints"]:
        """How much the distance of a pair may change with each joint, in any posture.

        Args:
            pair: As in `near`; None for the most that any pair's distance may.

        Returns:
            (n,) [m per rad or m]: times the joints' moves, a bound on the change of distance.
        """
        if pair is None:
            return np.max(list(self._reach.values()), axis=0)
        if pair not in self._drifts:
            index, moved_by = self._shapes.body_index, self._shapes.moved_by
            a, b = (index.get(name, 0) for name in pair)  # a wall is of the world
            moved = np.zeros(len(self._reach[a]))
            for body, other in ((a, b), (b, a)):
                own = list(moved_by[body] - moved_by[other])
                moved[own] = self._reach[body][own]
            self._drifts[pair] = moved
        return self._drifts[pair]

    def _judge(self, robot: Robot) -> None:
        """Find the links that always overlap, and those that cannot keep the clearance."""
        if not self.has_shapes:
            return
        rng, ahead = np.random.default_rng(0), 2 * self.clearance
        lower, upper = robot.limits.position.T
        seen: dict[Pair, list[float]] = {}
        for q in rng.uniform(lower, upper, (POSTURES, robot.n)):
            for pair, distance in self._shapes.distances(q, ahead).items():
                seen.setdefault(pair, []).append(distance)
        apart = {
            pair: float(np.quantile([*found, *[FAR] * (POSTURES - len(found))], ALWAYS))
            for pair, found in seen.items()
        }
        self._overlapping = frozenset(pair for pair, most in apart.items() if most <= 0.0)
        self._shapes.leave_out(self._overlapping)
        self._tight = {p: m / 2 for p, m in apart.items() if 0.0 < m / 2 < self.clearance}
        self._short = {
            pair: sum(d < self.wanted(pair) for d in found) / POSTURES
            for pair, found in seen.items()
            if pair not in self._overlapping
        }

    @property
    def mostly_short(self) -> str:
        """What stands in the way of a clear motion, in words; empty if nothing does."""
        worst = sorted(((share, pair) for pair, share in self._short.items()), reverse=True)
        told = ", ".join(
            f"{' and '.join(pair)} in {share:.0%}" for share, pair in worst[:WORST] if share > OFTEN
        )
        if not told:
            return ""
        return (
            f". Too near in that share of postures: {told}; judged are convex hulls of the "
            "collision shapes: split the shapes of those links in the file"
        )

    @property
    def nearer(self) -> str:
        """Pairs that are held to less than the clearance, in words; empty if none is."""
        return ", ".join(
            f"{a} and {b} {1e3 * wanted:.1f} mm" for (a, b), wanted in sorted(self._tight.items())
        )

    @property
    def is_judged(self) -> bool:
        """Whether shapes are known of all that is drawn, and every pair of them is looked at."""
        return self.has_shapes and not self.missing and not self.unjudged

    def _unjudged(self) -> tuple[str, ...]:
        """What has shapes, or is drawn, and cannot be judged, in words."""
        if not self.has_shapes:
            return ()
        pairs = ", ".join(" and ".join(pair) for pair in sorted(self._overlapping))
        bare, found = self._shapes.bare, [*filter(None, [self._shapes.planes])]
        if pairs:
            found.append(f"{pairs} overlap in nearly all postures")
        if bare:
            more = f" and {len(bare) - WORST} more" if len(bare) > WORST else ""
            shapes = "a collision shape" if len(bare) == 1 else "collision shapes"
            found.append(f"{', '.join(bare[:WORST])}{more} drawn without {shapes}")
        return tuple(found)

    def _room(self, q: Float[ndarray, " joints"]) -> tuple[Float[ndarray, "bodies 3 2"], Poses]:
        """Of the origin of each body that a joint moves to the walls [m]; and all poses."""
        origins, poses = self._shapes.origins(q)
        walls = np.zeros((3, 2)) if self.box is None else self.box
        return (origins[:, :, None] - walls) * (1.0, -1.0), poses

    def _wall_distances(self, q: Float[ndarray, " joints"], ahead: float) -> dict[Pair, float]:
        """Of bodies near or beyond a wall."""
        if self.box is None:
            return {}
        room, _ = self._room(q)
        places = np.argwhere(room <= ahead).tolist()
        return {self._wall_pair(*place): float(room[tuple(place)]) for place in places}

    def _near_walls(self, q: Float[ndarray, " joints"], ahead: float) -> list[Nearness]:
        """The same with slopes."""
        if self.box is None:
            return []
        (room, poses), found = self._room(q), []
        for row, axis, side in np.argwhere(room <= ahead).tolist():
            index = self._shapes.movable[row]
            inward = np.eye(3)[axis : axis + 1] * (1.0, -1.0)[side]
            slope = self._shapes.is_moved(index) * poses.rates(poses.origin[index][None], inward)[0]
            pair = self._wall_pair(row, axis, side)
            found.append(Nearness(pair, float(room[row, axis, side]), slope))
        return found

    def _wall_pair(self, row: int, axis: int, side: int) -> Pair:
        name = self._shapes.name(self._shapes.movable[row])
        return name, f"{WALLS[axis]} {('lower', 'upper')[side]} wall"


def is_wall(pair: Pair) -> bool:
    """Whether a pair is a body and a wall of the box."""
    return pair[1].endswith(" wall")
