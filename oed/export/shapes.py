"""What a robot looks like and touches with, body by body, for files that are written anew."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    Mesh,
    SceneGraphInspector,
    Shape,
    Sphere,
)

from oed.design.scene import load_scene
from oed.robot import Robot
from oed.robot.merged_tree import MergedTree

Kind = Literal["box", "sphere", "cylinder", "capsule", "ellipsoid", "mesh"]
DIGITS = "0123456789_"  # which converted meshes are numbered with
MESHES = "meshes"  # folder beside the robot's file
# Sizes of Drake's shapes as robot files count them: box edges, radii, lengths.
SIZES = {
    Box: ("box", lambda s: (s.width(), s.depth(), s.height())),
    Sphere: ("sphere", lambda s: (s.radius(),)),
    Cylinder: ("cylinder", lambda s: (s.radius(), s.length())),
    Capsule: ("capsule", lambda s: (s.radius(), s.length())),
    Ellipsoid: ("ellipsoid", lambda s: (s.a(), s.b(), s.c())),
}


@dataclass(frozen=True)
class BodyShape:
    """One shape of a body.

    Attributes:
        joint: Index of the joint that carries the body, -1 for the base.
        name: Of the shape, as no other.
        is_collision: Whether it touches; else it is drawn.
        kind: Of shape.
        size: Edges, radius and length, or half axes [m]; of a mesh its scale along each axis.
        R: (3, 3) its axes in the body frame.
        p: (3,) its origin in the body frame [m].
        mesh: File name of a mesh, in the folder `MESHES`; empty of others.
        colour: (4,) red, green, blue and opacity; None if the robot's file has none.
    """

    joint: int
    name: str
    is_collision: bool
    kind: Kind
    size: tuple[float, ...]
    R: Float[ndarray, "3 3"]
    p: Float[ndarray, "3"]
    mesh: str = ""
    colour: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Shapes:
    """All shapes of a robot.

    Attributes:
        shapes: Of all bodies and the base.
        note: What of the robot's file is missing among them, empty if nothing is.
    """

    shapes: tuple[BodyShape, ...] = ()
    note: str = ""

    def of(self, joint: int) -> Iterator[BodyShape]:
        """Those of a body, -1 for the base."""
        return (shape for shape in self.shapes if shape.joint == joint)


def collect_shapes(robot: Robot, out: Path) -> Shapes:
    """Read the shapes of a robot's file, and copy its meshes into the folder `MESHES`.

    Meshes are Wavefront OBJ, which every simulator reads; what collides is a convex hull.

    Args:
        robot: With or without a file.
        out: Folder in which the robot is to be written.

    Raises:
        RobotError: If the robot's file cannot be read.
    """
    if robot.description is None:
        return Shapes(note="the robot has no file, and so no shapes")
    scene = load_scene(robot)
    tree = MergedTree(scene.plant, robot.joint_names, robot.held)
    inspector = scene.scene_graph.model_inspector()
    meshes: dict[Path, str] = {}
    found: list[BodyShape] = []
    for number, geometry in enumerate(inspector.GetAllGeometryIds()):
        body = scene.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        joint, X_CB = tree.pose(body)
        kind, size, mesh = _shape(inspector.GetShape(geometry), out, meshes)
        if kind is None:
            continue
        X_CG = X_CB @ inspector.GetPoseInFrame(geometry)
        place = (np.array(X_CG.rotation().matrix()), np.array(X_CG.translation()))
        if inspector.GetIllustrationProperties(geometry) is not None:
            name, colour = f"{body.name()}_look_{number}", _colour(inspector, geometry)
            found.append(BodyShape(joint, name, False, kind, size, *place, mesh, colour))
        if inspector.GetProximityProperties(geometry) is not None:
            name = f"{body.name()}_touch_{number}"
            found.append(BodyShape(joint, name, True, kind, size, *place, mesh))
    return Shapes(tuple(found), scene.note)


def _shape(
    shape: Shape, out: Path, meshes: dict[Path, str]
) -> tuple[Kind | None, tuple[float, ...], str]:
    if isinstance(shape, Mesh | Convex):
        source = Path(shape.source().path())
        if source not in meshes:
            folder = out / MESHES
            folder.mkdir(parents=True, exist_ok=True)
            meshes[source] = f"{len(meshes)}_{source.name.lstrip(DIGITS)}"
            shutil.copyfile(source, folder / meshes[source])
        return "mesh", tuple(float(x) for x in shape.scale3()), meshes[source]
    if type(shape) in SIZES:
        kind, size = SIZES[type(shape)]
        return kind, tuple(float(x) for x in size(shape)), ""
    return None, (), ""


def _colour(inspector: SceneGraphInspector, geometry: GeometryId) -> tuple[float, ...] | None:
    properties = inspector.GetIllustrationProperties(geometry)
    if properties is None or not properties.HasProperty("phong", "diffuse"):
        return None
    found = properties.GetProperty("phong", "diffuse")
    return (found.r(), found.g(), found.b(), found.a())
