"""Where the mass of each link can be: a box around its collision geometry."""

from __future__ import annotations

import itertools
import logging
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import CalcObb, SceneGraph
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import DiagramBuilder

from oed.errors import RobotError
from oed.estimation.feasible.feasible_set import MassRegion
from oed.robot import Robot
from oed.robot.robot_file import bodies_of, joints_of, weld_free_bodies

# Covers and cables stick out of a collision shape by about this much.
CLEARANCE = 0.01  # [m]
PACKAGE_DEPTH = 5  # folders above a robot file in which its package may begin
CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def collision_regions(robot: Robot, *, clearance: float = CLEARANCE) -> tuple[MassRegion, ...]:
    """A box in the body frame around all collision shapes that each joint carries.

    Links whose file states no collision shape get none; joints that the robot holds are taken
    at zero.

    Args:
        robot: Loaded from a file.
        clearance: Added on all sides [m].

    Raises:
        RobotError: If the robot came from no file, or its shapes cannot be read.
    """
    path = Path(robot.source)
    if not path.is_file():
        raise RobotError(f"{robot.source!r}: collision geometry needs a robot file")
    plant, scene_graph = _load(path)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.zeros(plant.num_positions()))
    found: dict[int, list[ndarray]] = {}
    for body, carrier in _carried(plant, robot):
        joint = robot.joints[carrier]
        link = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(joint.link))
        X_WJ = link @ RigidTransform(RotationMatrix(joint.R_LJ), joint.p_LJ)
        X_JB = X_WJ.inverse() @ plant.EvalBodyPoseInWorld(context, body)
        found.setdefault(carrier, []).extend(
            X_JB @ corner for corner in _corners(plant, scene_graph, body, path)
        )
    return tuple(
        MassRegion.box(
            link,
            np.min(corners, axis=0) - clearance,
            np.max(corners, axis=0) + clearance,
            name="collision box",
        )
        for link, corners in sorted(found.items())
        if corners
    )


def _load(path: Path) -> tuple[MultibodyPlant, SceneGraph]:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    parser = Parser(plant)
    # A mesh named by package:// lies beside the file or above it.
    for folder in itertools.islice(path.resolve().parents, PACKAGE_DEPTH):
        if (folder / "package.xml").is_file():
            parser.package_map().AddPackageXml(str(folder / "package.xml"))
    drake_log = logging.getLogger("drake")
    level = drake_log.level
    drake_log.setLevel(logging.ERROR)
    try:
        parser.AddModels(str(path))
    except RuntimeError as error:
        raise RobotError(f"{path}: its shapes cannot be read: {error}") from error
    finally:
        drake_log.setLevel(level)
    weld_free_bodies(plant)
    plant.Finalize()
    return plant, scene_graph


def _carried(plant: MultibodyPlant, robot: Robot) -> list[tuple[RigidBody, int]]:
    """Each moving body with the active joint that carries it."""
    above = {joint.child_body().index(): joint for joint in joints_of(plant)}
    column = {name: i for i, name in enumerate(robot.joint_names)}
    carried = []
    for body in bodies_of(plant):
        place = body
        while place.index() in above and above[place.index()].name() not in column:
            place = above[place.index()].parent_body()
        if place.index() in above:
            carried.append((body, column[above[place.index()].name()]))
    return carried


def _corners(
    plant: MultibodyPlant, scene_graph: SceneGraph, body: RigidBody, path: Path
) -> list[Float[ndarray, "3"]]:
    inspector = scene_graph.model_inspector()
    corners = []
    for geometry in plant.GetCollisionGeometriesForBody(body):
        try:
            box = CalcObb(inspector.GetShape(geometry))
        except RuntimeError as error:
            raise RobotError(f"{path}: a shape of {body.name()}: {error}") from error
        if box is not None:
            X_BO = inspector.GetPoseInFrame(geometry) @ box.pose()
            corners += [X_BO @ (corner * box.half_width()) for corner in CORNERS]
    return corners
