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
    SceneGraphInspector,
    SignedDistancePair,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.tree import (
    BodyIndex,
    Frame,
    JacobianWrtVariable,
    PrismaticJoint,
    RigidBody,
)

from oed.design.reach import reaches
from oed.design.scene import Scene, load_scene
from oed.robot import Robot
from oed.robot.robot_file import bodies_of, joints_of, warnings_off

FAR = 0.3  # [m] beyond which a distance is not asked for
# [m] between links: where MoveIt Servo begins to slow down for self-collision
# (`self_collision_proximity_threshold`).
CLEARANCE = 0.01
POSTURES = 200  # random ones that tell which links cannot keep it
# Of postures in which links overlap that always do (MoveIt Setup Assistant's
# `min_collision_fraction`).
ALWAYS = 0.95
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


@dataclass(frozen=True, eq=False)
class _Place:
    """Where a shape is: its body, its pose in that, and 1 for each joint that moves it, else 0."""

    body: RigidBody
    X_BG: RigidTransform
    is_moved: Float[ndarray, " joints"]


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
        self._scene: Scene = load_scene(robot)
        self.box, self.clearance = box, clearance
        plant, scene_graph = self._scene.plant, self._scene.scene_graph
        planes = _leave_out_planes(scene_graph)
        self._moved_by = self._joints_below()
        self._leave_out_rigid()
        with warnings_off():  # of planes and soft bodies
            self._diagram = self._scene.builder.Build()
            self._context = self._diagram.CreateDefaultContext()
        self._plant_context = plant.GetMyMutableContextFromRoot(self._context)
        self._rest = np.array(plant.GetPositions(self._plant_context))
        inspector = scene_graph.model_inspector()
        shapes = inspector.NumGeometriesWithRole(Role.kProximity)
        self.has_shapes = shapes > 0 and not walls_only
        self.missing = self._scene.missing
        # Looking names up takes Drake longer than the distances do.
        self._pairs: dict[tuple[GeometryId, GeometryId], Pair] = {}
        self._joints = [plant.GetJointByName(name) for name in robot.joint_names]
        self._places = {g: self._place(g, inspector) for g in _collision_shapes(inspector)}
        self._body_index = {p.name(): int(p.index()) for p in bodies_of(plant)}
        self._reach = self._reaches(robot)
        self._overlapping: frozenset[Pair] = frozenset()
        self._tight: dict[Pair, float] = {}
        self._drifts: dict[Pair, Float[ndarray, " joints"]] = {}
        self._judge(robot)
        lacking = "" if self.has_shapes else "no shapes to check for collision"
        parts = (self._scene.note, lacking, planes, *self._exceptions())
        self.note = "; ".join(part for part in parts if part)

    def near(self, q: Float[ndarray, " joints"], ahead: float = FAR) -> list[Nearness]:
        """All pairs within a distance in a posture, each once, and all bodies near a wall.

        Args:
            q: The posture.
            ahead: The distance [m], at most `FAR`.
        """
        nearest = self._nearest(q)
        axes, moments = self._twists()
        between = [
            Nearness(pair, float(found.distance), self._slope(found, axes, moments))
            for pair, found in nearest.items()
            if found.distance <= ahead
        ]
        return [*between, *(found for found in self._near_walls() if found.distance <= ahead)]

    def distances(self, q: Float[ndarray, " joints"]) -> dict[Pair, float]:
        """As `near`, without the slopes [m]."""
        between = {pair: float(found.distance) for pair, found in self._nearest(q).items()}
        return between | {found.pair: found.distance for found in self._near_walls()}

    def _nearest(self, q: Float[ndarray, " joints"]) -> dict[Pair, SignedDistancePair]:
        """Pose the arm; of each pair of bodies the two shapes that are nearest."""
        plant = self._scene.plant
        posture = self._scene.positions(q, self._rest)
        plant.SetPositions(self._plant_context, posture)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        if not self.has_shapes:
            return {}
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
            a, b = (self._places[geometry].body for geometry in key)
            self._pairs[key] = (min(a.name(), b.name()), max(a.name(), b.name()))
        pair = self._pairs[key]
        return None if pair in self._overlapping else pair

    def _slope(
        self,
        found: SignedDistancePair,
        axes: Float[ndarray, "joints 3"],
        moments: Float[ndarray, "joints 3"],
    ) -> Float[ndarray, " joints"]:
        n = np.asarray(found.nhat_BA_W)
        slope = np.zeros(len(axes))
        for sign, geometry, p in ((1.0, found.id_A, found.p_ACa), (-1.0, found.id_B, found.p_BCb)):
            place = self._places[geometry]
            pose = self._scene.plant.EvalBodyPoseInWorld(self._plant_context, place.body)
            x, y, z = pose.multiply(place.X_BG.multiply(np.asarray(p)))
            turned = np.array([y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]])
            # n . (axis x (p - o)) of a joint at o, for all joints at once
            slope += sign * place.is_moved * (axes @ turned + moments @ n)
        return slope

    def _twists(self) -> tuple[Float[ndarray, "joints 3"], Float[ndarray, "joints 3"]]:
        """Of each joint in the present posture: its axis, and what it gives a point at 0.

        A point p that joint j moves has the velocity axis_j x p + moment_j per unit of it.
        """
        axes, moments = np.zeros((2, len(self._joints), 3))
        for j, joint in enumerate(self._joints):
            pose = joint.frame_on_child().CalcPoseInWorld(self._plant_context)
            if isinstance(joint, PrismaticJoint):
                moments[j] = pose.rotation().multiply(joint.translation_axis())
            else:
                axes[j] = pose.rotation().multiply(joint.revolute_axis())
                moments[j] = np.cross(pose.translation(), axes[j])
        return axes, moments

    def wanted(self, pair: Pair) -> float:
        """The distance that a pair should keep [m]."""
        return self._tight.get(pair, self.clearance)

    def spare(self, q: Float[ndarray, " joints"]) -> float:
        """What the tightest pair has beyond the distance that it should keep [m]."""
        distances = self.distances(q).items()
        return min((d - self.wanted(pair) for pair, d in distances), default=FAR - self.clearance)

    def is_clear(self, q: Float[ndarray, " joints"]) -> bool:
        """Whether every pair keeps the distance that it should, in a posture."""
        return self.spare(q) >= 0.0

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
            a, b = (self._body_index.get(name, 0) for name in pair)  # a wall is of the world
            moved = np.zeros(len(self._reach[a]))
            for body, other in ((a, b), (b, a)):
                own = list(self._moved_by[body] - self._moved_by[other])
                moved[own] = self._reach[body][own]
            self._drifts[pair] = moved
        return self._drifts[pair]

    def _place(self, geometry: GeometryId, inspector: SceneGraphInspector) -> _Place:
        body = self._scene.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        is_moved = np.zeros(len(self._joints))
        is_moved[list(self._moved_by[int(body.index())])] = 1.0
        return _Place(body, inspector.GetPoseInFrame(geometry), is_moved)

    def _reaches(self, robot: Robot) -> dict[int, Float[ndarray, " joints"]]:
        plant = self._scene.plant
        at_zero = self._scene.positions(np.zeros(robot.n), self._rest)
        plant.SetPositions(self._plant_context, at_zero)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        travel = np.abs(robot.limits.position).max(axis=1)
        return reaches(self._scene, self._plant_context, self._joints, self._moved_by, travel)

    def _judge(self, robot: Robot) -> None:
        """Find the links that always overlap, and those that cannot keep the clearance."""
        if not self.has_shapes:
            return
        rng = np.random.default_rng(0)
        lower, upper = robot.limits.position.T
        seen: dict[Pair, list[float]] = {}
        for q in rng.uniform(lower, upper, (POSTURES, robot.n)):
            for pair, distance in self.distances(q).items():
                if not is_wall(pair):
                    seen.setdefault(pair, []).append(distance)
        apart = {
            pair: float(np.quantile([*found, *[FAR] * (POSTURES - len(found))], ALWAYS))
            for pair, found in seen.items()
        }
        self._overlapping = frozenset(pair for pair, most in apart.items() if most <= 0.0)
        self._tight = {p: m / 2 for p, m in apart.items() if 0.0 < m / 2 < self.clearance}

    def _exceptions(self) -> list[str]:
        """What is not held to the clearance, in words."""
        overlapping = ", ".join(" and ".join(pair) for pair in sorted(self._overlapping))
        tight = ", ".join(
            f"{a} and {b} {1e3 * wanted:.1f} mm" for (a, b), wanted in sorted(self._tight.items())
        )
        return [
            f"not judged, as they overlap in nearly all postures: {overlapping}"
            if overlapping
            else "",
            f"too close by design, so half of the most that they part: {tight}" if tight else "",
        ]

    def _leave_out_rigid(self) -> None:
        """Filter pairs that no joint of the design moves against each other: they cost time."""
        plant, scene_graph = self._scene.plant, self._scene.scene_graph
        together: dict[frozenset[int], list[GeometryId]] = {}
        for index, movers in self._moved_by.items():
            shapes = plant.GetCollisionGeometriesForBody(plant.get_body(BodyIndex(index)))
            together.setdefault(movers, []).extend(shapes)
        for shapes in together.values():
            scene_graph.collision_filter_manager().Apply(
                CollisionFilterDeclaration().ExcludeWithin(GeometrySet(shapes))
            )

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


def _collision_shapes(inspector: SceneGraphInspector) -> list[GeometryId]:
    return list(inspector.GetAllGeometryIds(Role.kProximity))


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
