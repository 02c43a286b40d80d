"""A robot with its geometry in Drake, for collision checks and pictures; meshes may be missing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from oed.counted import counted
from oed.design.meshes import ReadableUrdf, with_readable_meshes
from oed.design.scratch_folder import ScratchFolder
from oed.errors import RobotError
from oed.robot import Robot, described
from oed.robot.robot_file import add_to, warnings_off, weld_free_bodies

# What a URDF is read without, until Drake can read it, and the note on that.
LESS_AND_LESS = (
    ((), ""),
    (("visual",), "the robot's drawings cannot be read"),
    (("visual", "collision"), "the robot's shapes cannot be read"),
)


@dataclass(frozen=True, eq=False)
class Scene:
    """A plant with its scene graph in an unfinished diagram.

    Attributes:
        builder: To which a visualizer may be added.
        plant: Finalized.
        scene_graph: Its geometry.
        columns: (n,) index in the plant's positions of each joint of the robot.
        note: What could not be shown, empty where all could.
        readable: The file with its converted meshes, which must live as long as the scene.
    """

    builder: DiagramBuilder
    plant: MultibodyPlant
    scene_graph: SceneGraph
    columns: ndarray
    note: str
    readable: _Readable | None = None

    @property
    def missing(self) -> tuple[str, ...]:
        """Meshes of collision shapes that are left out because they cannot be found or read."""
        return () if self.readable is None else self.readable.urdf.missing_shapes

    def positions(self, q: Float[ndarray, " joints"], rest: ndarray) -> ndarray:
        """All positions of the plant with the robot's joints at q and the others at `rest`."""
        everything = np.array(rest, dtype=float)
        everything[self.columns] = q
        return everything


def load_scene(robot: Robot) -> Scene:
    """Load the robot's own file with its geometry.

    Meshes that Drake cannot read are converted; those that are missing are left out and noted.

    Raises:
        RobotError: If the robot did not come from a file, or the file cannot be read even so.
    """
    file = robot.description
    if file is None:
        raise RobotError(f"{robot.name} does not come from a file: it has no geometry")
    with warnings_off():
        if file.format != "urdf":
            return _parse(robot, None, None, "")
        packages = tuple(sorted(file.packages.items()))
        readable = _readable_file(file.place.resolve(), file.text, packages)
        missing = _missing_note(readable.urdf.missing)
        edited = readable.folder.path / f"{file.path.stem}.urdf"
        refused = RobotError(f"{robot.source}: no geometry")
        # A colour that Drake refuses should cost the picture, not the check for collisions.
        for left_out, note in LESS_AND_LESS:
            edited.write_text(_without(readable.urdf.text, left_out), encoding="utf-8")
            try:
                return _parse(robot, edited, readable, "; ".join(filter(None, (missing, note))))
            except RobotError as error:
                refused = error
        raise refused


@dataclass(frozen=True, eq=False)
class _Readable:
    """A URDF with the folder of its converted meshes."""

    urdf: ReadableUrdf
    folder: ScratchFolder


@lru_cache(maxsize=1)
def _readable_file(source: Path, text: str, packages: tuple[tuple[str, Path], ...]) -> _Readable:
    """Converted once for the check and the picture."""
    folder = ScratchFolder.new("oed-meshes-")
    try:
        return _Readable(with_readable_meshes(text, source, folder.path, dict(packages)), folder)
    except ElementTree.ParseError as error:
        raise RobotError(f"{source}: no geometry: {error}") from error


def _parse(robot: Robot, edited: Path | None, readable: _Readable | None, note: str) -> Scene:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    try:
        if edited is None:
            add_to(Parser(plant), described(robot))
        else:
            Parser(plant).AddModels(edited)
    except (RuntimeError, ValueError) as error:
        raise RobotError(f"{robot.source}: no geometry: {error}") from error
    weld_free_bodies(plant)
    plant.Finalize()
    for name, position in robot.held.items():
        plant.GetJointByName(name).set_default_positions([position])
    columns = np.array([plant.GetJointByName(name).position_start() for name in robot.joint_names])
    return Scene(builder, plant, scene_graph, columns, note, readable)


def _missing_note(missing: tuple[str, ...]) -> str:
    if not missing:
        return ""
    lost = counted(len(missing), "mesh", "meshes")
    return f"{lost} cannot be found or read (the first is {missing[0]}): left out"


def _without(text: str, kinds: tuple[str, ...]) -> str:
    """A URDF without some elements of its links, and without its colours if any."""
    root = ElementTree.fromstring(text)  # noqa: S314  # the user's own robot file
    for link in root.iter("link"):
        for element in [e for kind in kinds for e in link.findall(kind)]:
            link.remove(element)
    for material in root.findall("material") if kinds else ():
        root.remove(material)
    return ElementTree.tostring(root, encoding="unicode")
