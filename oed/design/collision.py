"""How near an arm is to itself, and to the walls of a box, in a posture, by Drake's geometry.

Drake looks at the convex hull of every collision mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import (
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    HalfSpace,
    Role,
    SceneGraph,
    SignedDistancePair,
    Sphere,
)
from pydrake.multibody.tree import BodyIndex, Frame, JacobianWrtVariable, RigidBody

from oed.design.scene import Scene, load_scene
from oed.robot import Robot
from oed.robot.robot_file import joints_of, warnings_off

FAR = 0.3  # [m] beyond which a distance is not asked for
CLEARANCE = 0.01  # [m] wanted between bodies, or half of what they have at mid-range if less
NEIGHBOURLY = 0.02  # [m] that pairs which are not judged never exceed
POSTURES = 100  # random ones that tell neighbours
WALLS = ("x", "y", "z")
Pair = tuple[str, str]


@dataclass(frozen=True)
class Nearness:
    """Two things that are near each other in one posture.

    Attributes:
        pair: Names of two bodies, or of a body and a wall such as "x lower wall".
        distance: Between them [m]; negative where they overlap.
        slope: (n,) change of that distance with the joints [m per rad or m].
    """

    pair: Pair
    distance: float
    slope: Float[ndarray, " joints"]


class Surroundings:
    """A robot's shapes and the walls of its box, posed at will.

    Left out are pairs that no joint of the design moves against each other, pairs that Drake
    filters (a body and the one it is mounted on), and the hulls of neighbours in a shoulder or
    wrist: pairs that overlap at mid-range already, or that never part by more than 2 cm.

    Args:
        robot: Loaded from a file, with finite position limits.
        box: Lower and upper bound of x, y, z in the base frame [m], for the origins of the
            bodies; None for no box.

    Raises:
        ValueError: If a position is not limited.
        RobotError: If the robot has no file, or the file cannot be read.
    """

    def __init__(self, robot: Robot, box: Float[ndarray, "3 2"] | None = None) -> None:
        if not np.isfinite(robot.limits.position).all():
            raise ValueError("a clearance check needs finite position limits of every joint")
        self._scene: Scene = load_scene(robot)
        self.box = box
        plant = self._scene.plant
        planes = _leave_out_planes(self._scene.scene_graph)
        with warnings_off():  # of planes and soft bodies
            self._diagram = self._scene.builder.Build()
            self._context = self._diagram.CreateDefaultContext()
        self._plant_context = plant.GetMyMutableContextFromRoot(self._context)
        self._rest = np.array(plant.GetPositions(self._plant_context))
        self._moved_by = self._joints_below()
        self.middle = robot.limits.position.mean(axis=1)
        self._ignored: frozenset[Pair] = frozenset()
        inspector = self._scene.scene_graph.model_inspector()
        self.has_shapes = inspector.NumGeometriesWithRole(Role.kProximity) > 0
        self.missing_shapes = self._scene.missing_shapes
        # Looking names up takes Drake longer than the distances do.
        self._pairs: dict[tuple[GeometryId, GeometryId], Pair | None] = {}
        at_middle = self.distances(self.middle)
        overlapping = {p for p, distance in at_middle.items() if distance <= 0 and not is_wall(p)}
        self._ignored = frozenset(overlapping | self._neighbours(robot))
        self._at_middle = {p: distance for p, distance in at_middle.items() if distance > 0.0}
        pairs = ", ".join(" and ".join(pair) for pair in sorted(self._ignored))
        overlap = f"not judged, as they always nearly touch: {pairs}" if pairs else ""
        lacking = "" if self.has_shapes else "no shapes to check for collision"
        parts = (self._scene.note, lacking, planes, overlap)
        self.note = "; ".join(part for part in parts if part)

    def near(self, q: Float[ndarray, " joints"]) -> list[Nearness]:
        """All pairs within `FAR` in a posture, each once, and all bodies near a wall."""
        between = [
            Nearness(pair, float(found.distance), self._slope(found))
            for pair, found in self._nearest(q).items()
        ]
        return [*between, *self._near_walls()]

    def distances(self, q: Float[ndarray, " joints"]) -> dict[Pair, float]:
        """As `near`, without the slopes [m]."""
        between = {pair: float(found.distance) for pair, found in self._nearest(q).items()}
        return between | {found.pair: found.distance for found in self._near_walls()}

    def _nearest(self, q: Float[ndarray, " joints"]) -> dict[Pair, SignedDistancePair]:
        """Pose the arm; of each pair of bodies the two shapes that are nearest."""
        plant = self._scene.plant
        posture = self._scene.positions(q, self._rest)
        plant.SetPositions(self._plant_context, posture)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        query = plant.get_geometry_query_input_port().Eval(self._plant_context)
        nearest: dict[Pair, SignedDistancePair] = {}
        for found in query.ComputeSignedDistancePairwiseClosestPoints(FAR):
            pair = self._pair_of(found)
            if pair is not None and (
                pair not in nearest or found.distance < nearest[pair].distance
            ):
                nearest[pair] = found
        return nearest

    def _pair_of(self, found: SignedDistancePair) -> Pair | None:
        """Names of the two bodies; None for a pair that is not judged."""
        key = (found.id_A, found.id_B)
        if key not in self._pairs:
            a, b = (self._body(geometry) for geometry in key)
            pair = (min(a.name(), b.name()), max(a.name(), b.name()))
            is_rigid = self._moved_by[int(a.index())] == self._moved_by[int(b.index())]
            self._pairs[key] = None if is_rigid else pair
        pair = self._pairs[key]
        return None if pair in self._ignored else pair

    def _slope(self, found: SignedDistancePair) -> Float[ndarray, " joints"]:
        inspector = self._scene.scene_graph.model_inspector()
        rates = [
            self._velocity(self._body(g).body_frame(), inspector.GetPoseInFrame(g) @ p)
            for g, p in ((found.id_A, found.p_ACa), (found.id_B, found.p_BCb))
        ]
        return found.nhat_BA_W @ (rates[0] - rates[1])

    def _body(self, geometry: GeometryId) -> RigidBody:
        inspector = self._scene.scene_graph.model_inspector()
        return self._scene.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))

    def wanted(self, pair: Pair) -> float:
        """The distance that a pair should keep [m]: a neighbour cannot keep what a stranger can."""
        return min(CLEARANCE, max(self._at_middle.get(pair, np.inf), 0.0) / 2)

    def is_clear(self, q: Float[ndarray, " joints"]) -> bool:
        """Whether every pair keeps at least half of what it should, in a posture."""
        return all(
            distance >= self.wanted(pair) / 2 for pair, distance in self.distances(q).items()
        )

    def _neighbours(self, robot: Robot) -> set[Pair]:
        """Pairs of bodies that no random posture parts by more than `NEIGHBOURLY`."""
        if not self.has_shapes:
            return set()
        rng = np.random.default_rng(0)
        together: dict[Pair, int] = {}
        lower, upper = robot.limits.position.T
        for q in rng.uniform(lower, upper, (POSTURES, robot.n)):
            for pair, distance in self.distances(q).items():
                if distance < NEIGHBOURLY and not is_wall(pair):
                    together[pair] = together.get(pair, 0) + 1
        return {pair for pair, count in together.items() if count == POSTURES}

    def _near_walls(self) -> list[Nearness]:
        """Origins of bodies that a joint moves, near or beyond a wall."""
        if self.box is None:
            return []
        plant, found = self._scene.plant, []
        for index, movers in self._moved_by.items():
            if not movers:
                continue
            body = plant.get_body(BodyIndex(index))
            at = plant.EvalBodyPoseInWorld(self._plant_context, body).translation()
            room = np.stack([at - self.box[:, 0], self.box[:, 1] - at], axis=1)
            if room.min() > FAR:
                continue
            rates = self._velocity(body.body_frame(), np.zeros(3))
            for axis, side in zip(*np.nonzero(room <= FAR), strict=True):
                wall = f"{WALLS[axis]} {('lower', 'upper')[side]} wall"
                slope = rates[axis] * (1.0, -1.0)[side]
                found.append(Nearness((body.name(), wall), float(room[axis, side]), slope))
        return found

    def _velocity(self, frame: Frame, point: Float[ndarray, "3"]) -> Float[ndarray, "3 joints"]:
        """Velocity in the world of a point fixed to a frame, per unit velocity of each joint."""
        plant = self._scene.plant
        world = plant.world_frame()
        jacobian = plant.CalcJacobianTranslationalVelocity(
            self._plant_context,
            JacobianWrtVariable.kQDot,
            frame,
            point,  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
            world,
            world,
        )
        return jacobian[:, self._scene.columns]

    def _joints_below(self) -> dict[int, frozenset[int]]:
        """For every body, the columns of the design's joints between it and the world."""
        plant = self._scene.plant
        column = {int(c): i for i, c in enumerate(self._scene.columns)}
        inboard = {int(j.child_body().index()): j for j in joints_of(plant)}

        def walk(body: int) -> frozenset[int]:
            joint = inboard.get(body)
            if joint is None:
                return frozenset()
            moved = {column[joint.position_start()]} if _is_column(joint, column) else set()
            return walk(int(joint.parent_body().index())) | moved

        return {i: walk(i) for i in range(plant.num_bodies())}


def _leave_out_planes(scene_graph: SceneGraph) -> str:
    """Filter planes against all but spheres, which is all that Drake measures; say so."""
    inspector = scene_graph.model_inspector()
    shapes = {g: inspector.GetShape(g) for g in inspector.GetAllGeometryIds(Role.kProximity)}
    planes = [g for g, shape in shapes.items() if isinstance(shape, HalfSpace)]
    others = [g for g, shape in shapes.items() if not isinstance(shape, Sphere)]
    if len(others) == len(planes):
        return ""
    for plane in planes:
        scene_graph.collision_filter_manager().Apply(
            CollisionFilterDeclaration().ExcludeBetween(GeometrySet(plane), GeometrySet(others))
        )
    return "planes, such as a floor, are checked against spheres only" if planes else ""


def is_wall(pair: Pair) -> bool:
    """Whether a pair is a body and a wall of the box."""
    return pair[1].endswith(" wall")


def _is_column(joint, column: dict[int, int]) -> bool:  # a Drake joint of any kind
    return joint.num_positions() == 1 and joint.position_start() in column
