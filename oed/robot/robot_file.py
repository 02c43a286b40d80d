"""Robot files read by Drake's own Parser into a plant.

A plant without a scene graph leaves meshes unread, so missing ones stop nobody; only of MJCF are
they read, and left out where they cannot be.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, PrismaticJoint, RevoluteJoint, RigidBody
from pydrake.multibody.tree import Joint as DrakeJoint

from oed.errors import RobotError
from oed.robot.mjcf_file import without_meshes

SUFFIXES = (".urdf", ".sdf", ".xml", ".mjcf")


def load_plant(source: str | Path) -> MultibodyPlant:
    """Parse a file into a finalized continuous plant whose base is welded to the world."""
    path = Path(source)
    if not path.is_file():
        raise RobotError(f"{path}: no such robot file; give a URDF, SDF or MJCF file")
    if path.suffix.lower() not in SUFFIXES:
        raise RobotError(f"{path}: unknown kind of robot file; expected one of {SUFFIXES}")
    try:
        plant = _parsed(path, None)
    except RobotError:
        text = without_meshes(path)
        if text is None:
            raise
        plant = _parsed(path, text)
    weld_free_bodies(plant)
    plant.Finalize()
    return plant


def _parsed(path: Path, text: str | None) -> MultibodyPlant:
    """The plant of a file, or of the text in its place."""
    plant = MultibodyPlant(time_step=0.0)
    with warnings_off():
        try:
            if text is None:
                Parser(plant).AddModels(path)
            else:
                Parser(plant).AddModelsFromString(text, "xml")
        except RuntimeError as error:
            raise RobotError(f"{path}: Drake cannot read this file: {error}") from error
        except SystemExit as error:  # Drake's failed assertions
            condition = str(error).partition("condition ")[2] or str(error)
            raise RobotError(
                f"{path}: Drake cannot read this file: {condition} Look for a lower limit above "
                "its upper one, or a mass that is not positive"
            ) from error
    return plant


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
