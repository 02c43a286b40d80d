"""The arm moving, as Drake's Meshcat shows it, recorded: it needs no server."""

# pydrake's stubs want float64 arrays where ndarray is given.
# pyright: reportArgumentType=false

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import (
    Meshcat,
    MeshcatAnimation,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Role,
)
from pydrake.multibody.tree import RigidBody

from oed.design.scene import Scene, load_scene
from oed.dynamics.motion import Motion
from oed.errors import OedError
from oed.report.camera import FIELD_OF_VIEW, framing
from oed.report.replay import Replay
from oed.report.skeleton import body_poses, skeleton
from oed.robot import Robot
from oed.robot.robot_file import warnings_off

FRAMES = 400  # of a recording, between which the viewer interpolates
FRAMES_PER_SECOND = 25.0  # as films have; fewer of a motion that is longer than FRAMES allow
NEVER_ENDING = 1_000_000  # repetitions
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))  # of a box of half edges 1
BACKGROUND = (0.85, 0.88, 0.91)  # before which white arms and dark ones stand out
NEAR, FAR = 0.01, 100.0  # [m] what the camera sees
# Beside the library of figures (2 MB) and the figures this keeps a page below 6 MB, which a mail can carry.
LARGEST = 3_300_000  # [B]
BODIES = "/bodies"  # of Meshcat's tree
WAYS = ((Role.kIllustration, "drawings"), (Role.kProximity, "collision shapes"))


@dataclass(frozen=True)
class Recorded:
    """What a recording came to.

    Attributes:
        replay: The moving arm; None where none could be made.
        note: What could not be shown, or not as it is; empty where all could.
    """

    replay: Replay | None
    note: str


def frame_times(horizon: float) -> Float[ndarray, " frames"]:
    """When a motion of that length [s] is to be shown [s]."""
    frames = min(int(np.ceil(FRAMES_PER_SECOND * horizon)), FRAMES)
    return np.linspace(0.0, horizon, frames + 1)


def show_motion(robot: Robot, motion: Motion) -> Replay:
    """The arm moving in three dimensions: a notebook shows it where it ends a cell.

    Args:
        robot: The arm, drawn as lines between its joints where its file has no shapes.
        motion: N instants; of more than some hundred, some are left out.

    Returns:
        The moving picture; its caption tells what could not be shown.

    Raises:
        OedError: If no picture can be made on this machine.
    """
    step = -(-len(motion) // FRAMES)
    found = record_motion(robot, motion[::step])
    if found.replay is None:
        raise OedError(found.note)
    if not found.note:
        return found.replay
    return dataclasses.replace(found.replay, caption=f"{found.replay.caption} Note: {found.note}.")


def record_motion(robot: Robot, motion: Motion, *, largest: int = LARGEST) -> Recorded:
    """Record a motion, to be played on a page.

    The arm is shown by what its file has to be seen, else by what collides, else as lines between
    its joints: the first of these that there is and that is small enough.

    Args:
        robot: The arm; Meshcat's server lives only inside this call.
        motion: At `frame_times`.
        largest: What it may add to a page [B].

    Returns:
        The recording, and a note on what could not be shown; empty where all could.
    """
    try:
        with warnings_off():  # it announces an address where nobody will listen
            meshcat = Meshcat()
    except RuntimeError as error:  # no free port, or no network at all
        return Recorded(None, f"no recording: Meshcat cannot start: {error}")
    instead, why = "", f"{robot.name} has no shapes to show"
    for role, kind in WAYS:
        try:
            scene = load_scene(robot)
        except OedError as error:
            why = str(error)
            break
        if not scene.scene_graph.model_inspector().NumGeometriesWithRole(role):
            why = why if instead else scene.note or why
            continue
        replay = _played(meshcat, *_shapes(meshcat, scene, motion, role))
        if len(replay.packed) <= largest:
            said = f"drawn by its {kind}: {instead}" if instead else ""
            return Recorded(replay, "; ".join(filter(None, (scene.note, said))))
        instead = why = f"its {kind} would take {len(replay.packed) / 1e6:.1f} MB of the page"
    replay = _played(meshcat, *_lines(meshcat, robot, motion))
    return Recorded(replay, f"drawn as lines between its joints: {why}")


def _shapes(
    meshcat: Meshcat, scene: Scene, motion: Motion, role: Role
) -> tuple[MeshcatAnimation, Float[ndarray, "points 3"]]:
    """The animation of what a robot's file has to be seen, and the corners of all boxes around it."""
    meshcat.Delete()
    visualizer = MeshcatVisualizer.AddToBuilder(
        scene.builder, scene.scene_graph, meshcat, MeshcatVisualizerParams(role=role)
    )
    diagram = scene.builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = scene.plant.GetMyMutableContextFromRoot(context)
    rest = np.array(scene.plant.GetPositions(plant_context))
    boxes = list(_boxes(scene, role))
    points: list[ndarray] = []
    visualizer.StartRecording(False)
    for t, q in zip(motion.t, motion.q, strict=True):
        context.SetTime(float(t))
        posture = scene.positions(np.asarray(q), rest)
        scene.plant.SetPositions(plant_context, posture)
        diagram.ForcedPublish(context)
        points += [
            scene.plant.EvalBodyPoseInWorld(plant_context, body).multiply(box).T
            for body, box in boxes
        ]
    visualizer.StopRecording()
    return visualizer.get_mutable_recording(), np.concatenate(points)


def _boxes(scene: Scene, role: Role) -> Iterator[tuple[RigidBody, Float[ndarray, "3 8"]]]:
    """Every body with the corners of the box around each of its shapes, in its frame [m]."""
    inspector = scene.scene_graph.model_inspector()
    for shape in inspector.GetAllGeometryIds(role):
        box = inspector.GetObbInGeometryFrame(shape)
        body = scene.plant.GetBodyFromFrameId(inspector.GetFrameId(shape))
        if box is not None and body is not None:  # a half space has none
            corners = box.pose().multiply((CORNERS * box.half_width()).T)
            yield body, inspector.GetPoseInFrame(shape).multiply(corners)


def _lines(
    meshcat: Meshcat, robot: Robot, motion: Motion
) -> tuple[MeshcatAnimation, Float[ndarray, "points 3"]]:
    """The animation of lines between joints, and the corners of all boxes around them."""
    meshcat.Delete()
    parts = skeleton(robot)
    for k, part in enumerate(parts):
        path = f"{BODIES}/{part.body}/{k}"
        meshcat.SetObject(path, part.shape, part.colour)
        meshcat.SetTransform(path, part.place)
    points: list[ndarray] = []
    meshcat.StartRecording(set_visualizations_while_recording=False)
    for t, q in zip(motion.t, motion.q, strict=True):
        poses = body_poses(robot, np.asarray(q))
        for body, pose in poses.items():
            meshcat.SetTransform(f"{BODIES}/{body}", pose, float(t))
        points += [
            poses[part.body].multiply(part.place.multiply((CORNERS * part.size).T)).T
            for part in parts
        ]
    meshcat.StopRecording()
    return meshcat.get_mutable_recording(), np.concatenate(points)


def _played(
    meshcat: Meshcat, animation: MeshcatAnimation, points: Float[ndarray, "points 3"]
) -> Replay:
    """What plays an animation again and again, in a picture that it fills."""
    animation.set_loop_mode(MeshcatAnimation.LoopMode.kLoopRepeat)
    animation.set_repetitions(NEVER_ENDING)
    meshcat.SetAnimation(animation)
    for unseen in ("/Grid", "/Axes"):
        meshcat.SetProperty(unseen, "visible", False)
    for edge in ("top_color", "bottom_color"):
        meshcat.SetProperty("/Background/<object>", edge, list(BACKGROUND))
    camera = framing(points)
    meshcat.SetCamera(
        Meshcat.PerspectiveCamera(fov=FIELD_OF_VIEW, aspect=camera.aspect, near=NEAR, far=FAR)
    )
    meshcat.SetCameraPose(camera.position, camera.target)
    return Replay.of(meshcat.StaticHtml(), camera.aspect)
