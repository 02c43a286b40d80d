"""An arm's shapes in a posture, by Drake: which are near each other, and how fast they part.

Drake looks at the convex hull of every collision mesh.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, PrismaticJoint, RigidBody
from pydrake.multibody.tree import Joint as DrakeJoint

from oed.design.poses import Poses, cross_rows
from oed.design.reach import reaches
from oed.design.scene import Scene, load_scene
from oed.robot import Robot
from oed.robot.robot_file import bodies_of, joints_of, warnings_off

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


class PosedShapes:
    """The collision shapes of a robot's file, posed at will.

    Pairs that no joint of the design moves against each other are left out, and those that Drake
    leaves out: links that one joint of the file connects.

    Args:
        robot: Loaded from a file.

    Raises:
        RobotError: If the robot has no file, or the file cannot be read.
    """

    bare: tuple[str, ...]  # bodies that are drawn and have no collision shape

    def __init__(self, robot: Robot) -> None:
        self._scene: Scene = load_scene(robot)
        plant, scene_graph = self._scene.plant, self._scene.scene_graph
        self.planes = _leave_out_planes(scene_graph)
        self.moved_by = _joints_below(self._scene)
        _leave_out_rigid(self._scene, self.moved_by)
        with warnings_off():  # of planes and soft bodies
            diagram = self._scene.builder.Build()
            self._root = diagram, diagram.CreateDefaultContext()
        self._context = plant.GetMyMutableContextFromRoot(self._root[1])
        self._rest = np.array(plant.GetPositions(self._context))
        self._joints = [plant.GetJointByName(name) for name in robot.joint_names]
        self._bodies = sorted(bodies_of(plant), key=lambda body: int(body.index()))
        self.body_index = {body.name(): int(body.index()) for body in self._bodies}
        self._is_moved = np.zeros((len(self._bodies), robot.n))
        for index, movers in self.moved_by.items():
            self._is_moved[index, list(movers)] = 1.0
        # Index of each body that a joint moves.
        self.movable = [index for index, movers in self.moved_by.items() if movers]
        frames = [_on_body(joint) for joint in self._joints]
        self._joint_body = [int(joint.child_body().index()) for joint in self._joints]
        self._joint_origin, self._joint_axis = np.array(frames).reshape(-1, 2, 3).swapaxes(0, 1)
        self.is_slide = np.array([isinstance(joint, PrismaticJoint) for joint in self._joints])
        self._read_shapes()
        self.missing = self._scene.missing
        self.note = self._scene.note

    def _read_shapes(self) -> None:
        """Numbers in place of Drake's objects: looking these up takes longer than distances do."""
        plant, inspector = self._scene.plant, self._scene.scene_graph.model_inspector()
        shapes = list(inspector.GetAllGeometryIds(Role.kProximity))
        self.count = len(shapes)
        self._body_of, self._in_body = {}, {}
        for shape in shapes:
            body = plant.GetBodyFromFrameId(inspector.GetFrameId(shape))
            self._body_of[shape.get_value()] = int(body.index())
            self._in_body[shape.get_value()] = inspector.GetPoseInFrame(shape).GetAsMatrix34()
        self._pairs: dict[tuple[int, int], Pair] = {}
        self.bare = tuple(body.name() for body in self._bodies if _is_bare(body, inspector, plant))

    def near(self, q: Float[ndarray, " joints"], ahead: float) -> list[Nearness]:
        """All pairs of bodies within a distance in a posture, each once, by its nearest shapes.

        Args:
            q: The posture.
            ahead: The distance [m].
        """
        nearest = self._nearest(q, ahead)
        slopes = self._slopes(list(nearest.values()))
        return [
            Nearness(pair, float(found.distance), slope)
            for (pair, found), slope in zip(nearest.items(), slopes, strict=True)
        ]

    def distances(self, q: Float[ndarray, " joints"], ahead: float) -> dict[Pair, float]:
        """As `near`, without the slopes [m]."""
        nearest = self._nearest(q, ahead)
        return {pair: float(found.distance) for pair, found in nearest.items()}

    def leave_out(self, pairs: Iterable[Pair]) -> None:
        """Do not look at some pairs again: of shapes that overlap deeply a distance takes long."""
        plant, graph = self._scene.plant, self._scene.scene_graph
        filters = graph.collision_filter_manager(graph.GetMyMutableContextFromRoot(self._root[1]))
        for pair in pairs:
            of_each = (
                GeometrySet(plant.GetCollisionGeometriesForBody(self._bodies[index]))
                for index in (self.body_index[name] for name in pair)
            )
            filters.Apply(CollisionFilterDeclaration().ExcludeBetween(*of_each))

    def origins(self, q: Float[ndarray, " joints"]) -> tuple[Float[ndarray, "bodies 3"], Poses]:
        """Of all bodies that a joint moves, and all poses."""
        self._pose(q)
        poses = self._poses()
        return poses.origin[self.movable], poses

    def name(self, index: int) -> str:
        """Of a body."""
        return self._bodies[index].name()

    def is_moved(self, index: int) -> Float[ndarray, " joints"]:
        """1 for each joint that moves a body, else 0."""
        return self._is_moved[index]

    def reaches(self, travel: Float[ndarray, " joints"]) -> dict[int, Float[ndarray, " joints"]]:
        """Of every body, how far its furthest point moves per unit of each joint, at most."""
        self._pose(np.zeros(len(self._joints)))
        return reaches(self._scene, self._context, self._joints, self.moved_by, travel)

    def _pose(self, q: Float[ndarray, " joints"]) -> None:
        posture = self._scene.positions(q, self._rest)
        self._scene.plant.SetPositions(self._context, posture)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape

    def _nearest(
        self, q: Float[ndarray, " joints"], ahead: float
    ) -> dict[Pair, SignedDistancePair]:
        """Pose the arm; of each pair of bodies the two shapes that are nearest."""
        self._pose(q)
        query = self._scene.plant.get_geometry_query_input_port().Eval(self._context)
        nearest: dict[Pair, SignedDistancePair] = {}
        least: dict[Pair, float] = {}
        for found in query.ComputeSignedDistancePairwiseClosestPoints(ahead):
            pair = self._pair(found.id_A.get_value(), found.id_B.get_value())
            distance = found.distance
            if distance < least.get(pair, np.inf):
                nearest[pair], least[pair] = found, distance
        return nearest

    def _pair(self, a: int, b: int) -> Pair:
        """Names of the two bodies that two shapes belong to, in their order."""
        if (a, b) not in self._pairs:
            one, other = (self.name(self._body_of[shape]) for shape in (a, b))
            self._pairs[a, b] = (min(one, other), max(one, other))
        return self._pairs[a, b]

    def _poses(self) -> Poses:
        """In the present posture."""
        plant, context = self._scene.plant, self._context
        X_WB = np.zeros((len(self._bodies), 3, 4))
        for index in self.movable:
            X_WB[index] = plant.EvalBodyPoseInWorld(context, self._bodies[index]).GetAsMatrix34()
        rotation, origin = X_WB[:, :, :3], X_WB[:, :, 3]
        carrier = rotation[self._joint_body]
        along = np.einsum("jik,jk->ji", carrier, self._joint_axis)
        at = origin[self._joint_body] + np.einsum("jik,jk->ji", carrier, self._joint_origin)
        slides = self.is_slide[:, None]
        axes = np.where(slides, 0.0, along)
        return Poses(rotation, origin, axes, np.where(slides, along, cross_rows(at, axes)))

    def _slopes(self, found: Sequence[SignedDistancePair]) -> Float[ndarray, "pairs joints"]:
        """Change of each distance with the joints, in the present posture."""
        if not found:
            return np.zeros((0, len(self._joints)))
        poses, n = self._poses(), np.array([pair.nhat_BA_W for pair in found])
        shapes = [f.id_A.get_value() for f in found] + [f.id_B.get_value() for f in found]
        points = np.array([f.p_ACa for f in found] + [f.p_BCb for f in found])
        body = [self._body_of[shape] for shape in shapes]
        X_BG = np.array([self._in_body[shape] for shape in shapes])
        p_B = np.einsum("kij,kj->ki", X_BG[:, :, :3], points) + X_BG[:, :, 3]
        p_W = np.einsum("kij,kj->ki", poses.rotation[body], p_B) + poses.origin[body]
        rates = self._is_moved[body] * poses.rates(p_W, np.concatenate([n, -n]))
        return rates[: len(found)] + rates[len(found) :]


def _is_bare(body: RigidBody, inspector: SceneGraphInspector, plant: MultibodyPlant) -> bool:
    """Whether a body is drawn and has nothing that could be found to collide."""
    frame = plant.GetBodyFrameIdIfExists(body.index())
    if frame is None:
        return False
    drawn, shapes = (
        inspector.NumGeometriesForFrameWithRole(frame, role)
        for role in (Role.kIllustration, Role.kProximity)
    )
    return drawn > 0 and shapes == 0


def _on_body(joint: DrakeJoint) -> tuple[ndarray, ndarray]:
    """A joint's origin and axis in the frame of the body that it moves."""
    X_BF = joint.frame_on_child().GetFixedPoseInBodyFrame()
    is_slide = isinstance(joint, PrismaticJoint)
    axis = joint.translation_axis() if is_slide else joint.revolute_axis()  # pyright: ignore[reportAttributeAccessIssue]  # a joint with one position turns or slides
    return np.asarray(X_BF.translation()), np.asarray(X_BF.rotation().multiply(axis))


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


def _leave_out_rigid(scene: Scene, moved_by: dict[int, frozenset[int]]) -> None:
    """Filter pairs that no joint of the design moves against each other: they cost time."""
    together: dict[frozenset[int], list[GeometryId]] = {}
    for index, movers in moved_by.items():
        shapes = scene.plant.GetCollisionGeometriesForBody(scene.plant.get_body(BodyIndex(index)))
        together.setdefault(movers, []).extend(shapes)
    for shapes in together.values():
        scene.scene_graph.collision_filter_manager().Apply(
            CollisionFilterDeclaration().ExcludeWithin(GeometrySet(shapes))
        )


def _joints_below(scene: Scene) -> dict[int, frozenset[int]]:
    """For every body, the columns of the design's joints between it and the world."""
    plant = scene.plant
    column = {int(c): i for i, c in enumerate(scene.columns)}
    inboard = {int(j.child_body().index()): j for j in joints_of(plant)}

    def walk(body: int) -> frozenset[int]:
        joint = inboard.get(body)
        if joint is None:
            return frozenset()
        moved = {column[joint.position_start()]} if _is_column(joint, column) else set()
        return walk(int(joint.parent_body().index())) | moved

    return {i: walk(i) for i in range(plant.num_bodies())}


def _is_column(joint: DrakeJoint, column: dict[int, int]) -> bool:
    return joint.num_positions() == 1 and joint.position_start() in column
