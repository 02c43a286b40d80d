"""A robot's description read by Drake's own Parser into a plant.

A plant without a scene graph leaves meshes unread, so missing ones stop nobody; only of MJCF are
they read, and left out where they cannot be.
"""

from __future__ import annotations

import dataclasses
import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, PrismaticJoint, RevoluteJoint, RigidBody
from pydrake.multibody.tree import Joint as DrakeJoint

from oed.errors import RobotError
from oed.robot import sdf_file
from oed.robot.description import RobotDescription, read_description
from oed.robot.mjcf_file import without_meshes
from oed.robot.xml_tree import parse_xml

FILE_TYPES = {"urdf": "urdf", "sdf": "sdf", "mjcf": "xml"}  # as Drake calls them
# Where Drake found a fault in a text that is no file.
PLACE = re.compile(r"<literal-string>\.\w+:(\d+): (error: )?(ERROR: )?")


def open_robot(
    source: str | Path, *, place: Path | None = None
) -> tuple[RobotDescription, MultibodyPlant]:
    """Open a robot's file as one that Drake can read.

    Args:
        source: As of `read_description`.
        place: Likewise.

    Returns:
        The description, without meshes where these cannot be read, and a plant of it.

    Raises:
        RobotError: In one line that names the file.
    """
    description = read_description(source, place=place)
    try:
        return description, load_plant(description)
    except RobotError:
        if description.format != "mjcf":
            raise
        tree = parse_xml(description.text.encode(), str(description.path))
        if tree.root.find("asset/mesh") is None:
            raise
        lost = without_meshes(tree.root)
        note = f"meshes cannot be read, so that bodies have no inertia: {', '.join(lost[:5])}"
        bare = dataclasses.replace(
            description,
            text=tree.text(),
            notes=(*description.notes, *((note,) if lost else ())),
        )
        return bare, load_plant(bare)


def load_plant(source: str | Path | RobotDescription) -> MultibodyPlant:
    """Parse a robot into a finalized continuous plant whose base is welded to the world.

    Raises:
        RobotError: In one line that names the file.
    """
    if not isinstance(source, RobotDescription):
        return open_robot(source)[1]
    plant = MultibodyPlant(time_step=0.0)
    with warnings_off():
        try:
            add_to(Parser(plant), source)
            weld_free_bodies(plant)
            plant.Finalize()
        except (RuntimeError, ValueError) as error:
            raise RobotError(
                f"{source.path}: Drake cannot read this file: {_told(error)}"
            ) from error
        except SystemExit as error:  # Drake's failed assertions
            condition = str(error).partition("condition ")[2] or str(error)
            raise RobotError(
                f"{source.path}: Drake cannot read this file: {condition} Look for a lower limit "
                "above its upper one, or a mass that is not positive"
            ) from error
    return plant


def add_to(parser: Parser, description: RobotDescription) -> None:
    """Let a parser read a robot, with its shapes where the parser has a scene graph."""
    text = description.text
    if description.format == "sdf":
        text = sdf_file.located(text, description.place)
    parser.AddModelsFromString(text, FILE_TYPES[description.format])


def _told(error: Exception) -> str:
    text = PLACE.sub(r"line \1: ", str(error))
    if "form one or more loops" in text:
        return "its joints form a closed loop, and only open chains can be modelled; cut the loop"
    return text


@contextmanager
def warnings_off() -> Iterator[None]:
    """Silence Drake: it warns about transmissions, mimic joints and cameras, all harmless here."""
    drake_log = logging.getLogger("drake")
    level = drake_log.level
    drake_log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        drake_log.setLevel(level)


def weld_free_bodies(plant: MultibodyPlant) -> None:
    """Fix every body that no joint carries to the world: an arm stands on its base."""
    carried = {joint.child_body().index() for joint in joints_of(plant)}
    for body in bodies_of(plant):
        if body.index() != plant.world_body().index() and body.index() not in carried:
            plant.WeldFrames(plant.world_frame(), body.body_frame())


def outward_names(plant: MultibodyPlant) -> tuple[str, ...]:
    """Movable joints branch by branch from the base, whatever the file's order."""
    inboard: dict[int, list[DrakeJoint]] = {}
    for joint in joints_of(plant):
        inboard.setdefault(int(joint.parent_body().index()), []).append(joint)

    def beyond(body: int) -> list[str]:
        names: list[str] = []
        for joint in inboard.get(body, []):
            names += [joint.name()] if is_movable(joint) else []
            names += beyond(int(joint.child_body().index()))
        return names

    return tuple(beyond(int(plant.world_body().index())))


def joints_of(plant: MultibodyPlant) -> list[DrakeJoint]:
    """All joints, welds included."""
    return [plant.get_joint(index) for index in plant.GetJointIndices()]


def bodies_of(plant: MultibodyPlant) -> list[RigidBody]:
    """All bodies, the world first."""
    return [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]


def is_movable(joint: DrakeJoint) -> bool:
    """Whether this joint can be an active one."""
    return isinstance(joint, RevoluteJoint | PrismaticJoint)
