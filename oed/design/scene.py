"""A robot with its geometry in Drake, for collision checks and pictures; meshes may be missing."""

from __future__ import annotations

import logging
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from oed.errors import RobotError
from oed.robot import Robot
from oed.robot.robot_file import weld_free_bodies

DRAWABLE = (".obj", ".gltf", ".glb", ".vtk", ".stl", ".dae")


@dataclass(frozen=True, eq=False)
class Scene:
    """A plant with its scene graph in an unfinished diagram.

    Attributes:
        builder: To which a visualizer may be added.
        plant: Finalized.
        scene_graph: Its geometry.
        columns: (n,) index in the plant's positions of each joint of the robot.
        note: What could not be shown, empty where all could.
    """

    builder: DiagramBuilder
    plant: MultibodyPlant
    scene_graph: SceneGraph
    columns: ndarray
    note: str

    def positions(self, q: Float[ndarray, " joints"], rest: ndarray) -> ndarray:
        """All positions of the plant with the robot's joints at q and the others at `rest`."""
        everything = np.array(rest, dtype=float)
        everything[self.columns] = q
        return everything


def load_scene(robot: Robot) -> Scene:
    """Load the robot's own file with its geometry.

    Geometry that cannot be read (a mesh that is missing, a package that is not installed) makes
    Drake refuse the file; it is then read without its meshes.

    Raises:
        RobotError: If the robot did not come from a file, or the file cannot be read even so.
    """
    if robot.source.startswith("builtin:") or not Path(robot.source).is_file():
        raise RobotError(f"{robot.name} does not come from a file: it has no geometry")
    drake_log = logging.getLogger("drake")
    level = drake_log.level
    drake_log.setLevel(logging.CRITICAL)
    try:
        return _parse(robot, Path(robot.source).read_text(encoding="utf-8"), "")
    except RuntimeError:
        bare = _without_meshes(Path(robot.source).read_text(encoding="utf-8"))
        try:
            return _parse(robot, bare, "the robot's meshes cannot be read and are left out")
        except RuntimeError as again:
            raise RobotError(f"{robot.source}: no geometry: {again}") from again
    finally:
        drake_log.setLevel(level)


def _parse(robot: Robot, text: str, note: str) -> Scene:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    parser = Parser(plant)
    source = Path(robot.source).resolve()
    for folder in source.parents:
        # A URDF names its meshes by package; the packages lie in the folders above it.
        if (folder / "package.xml").is_file():
            parser.package_map().AddPackageXml(str(folder / "package.xml"))
    _add_named_packages(parser, text, source)
    with tempfile.TemporaryDirectory(dir=None) as scratch:
        edited = Path(scratch) / source.name
        edited.write_text(text, encoding="utf-8")
        parser.AddModels(str(source if not note else edited))
    weld_free_bodies(plant)
    plant.Finalize()
    columns = np.array([plant.GetJointByName(name).position_start() for name in robot.joint_names])
    return Scene(builder, plant, scene_graph, columns, note)


def _add_named_packages(parser: Parser, text: str, source: Path) -> None:
    """Packages that the file names and that a folder above it is called after or holds."""
    for package in set(re.findall(r"package://([^/\"']+)/", text)):
        if parser.package_map().Contains(package):
            continue
        for folder in source.parents:
            found = folder if folder.name == package else folder / package
            if found.is_dir():
                parser.package_map().Add(package, str(found))
                break


def _without_meshes(text: str) -> str:
    """The file without its visual and collision elements."""
    return re.sub(r"<(visual|collision)\b.*?</\1>", "", text, flags=re.DOTALL)
