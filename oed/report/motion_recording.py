"""The arm moving, as one HTML page that needs no server: Drake's Meshcat, recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams, Role, SceneGraph
from pydrake.multibody.tree import BodyIndex

from oed.design.scene import load_scene
from oed.dynamics.motion import Motion
from oed.errors import OedError
from oed.report.json_file import write_atomically
from oed.robot import Robot
from oed.robot.robot_file import warnings_off

FRAMES_PER_SECOND = 25.0
# From where the camera looks, and how many times the arm's reach it stands off: three.js's view
# is 75 degrees high, and what moves at that reach then fills most of it.
VIEW = np.array([0.8, -0.5, 0.35])
STAND_OFF = 1.7


def record_motion(robot: Robot, motion: Motion, path: str | Path) -> str:
    """Write a page that plays a motion; it holds all it needs.

    Meshcat's server lives only inside this call.

    Args:
        robot: Loaded from a file with geometry.
        motion: At `FRAMES_PER_SECOND` or so.
        path: Of the page.

    Returns:
        A note on what could not be shown; empty where all could. Where there is nothing to
        show, no page is written.
    """
    try:
        scene = load_scene(robot)
    except OedError as error:
        return f"no recording: {error}"
    drawn = _drawn_role(scene.scene_graph)
    if drawn is None:
        return f"no recording: {scene.note or 'the robot has no shapes to show'}"
    try:
        with warnings_off():  # it announces an address where nobody will listen
            meshcat = Meshcat()
    except RuntimeError as error:  # no free port, or no network at all
        return f"no recording: Meshcat cannot start: {error}"
    visualizer = MeshcatVisualizer.AddToBuilder(
        scene.builder, scene.scene_graph, meshcat, MeshcatVisualizerParams(role=drawn)
    )
    diagram = scene.builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = scene.plant.GetMyMutableContextFromRoot(context)
    rest = np.array(scene.plant.GetPositions(plant_context))
    bodies = [
        scene.plant.get_body(BodyIndex(k)) for k in range(1, scene.plant.num_bodies())
    ]  # all but the world
    places: list[ndarray] = []
    visualizer.StartRecording(False)
    for t, q in zip(motion.t, motion.q, strict=True):
        context.SetTime(float(t))
        posture = scene.positions(np.asarray(q), rest)
        scene.plant.SetPositions(plant_context, posture)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        diagram.ForcedPublish(context)
        places += [
            np.asarray(scene.plant.EvalBodyPoseInWorld(plant_context, body).translation())
            for body in bodies
        ]
    visualizer.StopRecording()
    visualizer.PublishRecording()
    _frame(meshcat, np.array(places))
    write_atomically(path, meshcat.StaticHtml())
    return scene.note


def _frame(meshcat: Meshcat, places: Float[ndarray, "places 3"]) -> None:
    """Have the camera stand where all that moves fills the picture."""
    lowest, highest = places.min(axis=0), places.max(axis=0)
    middle = (lowest + highest) / 2
    reach = float(np.linalg.norm(highest - lowest)) / 2
    if reach > 0:
        meshcat.SetCameraPose(middle + STAND_OFF * reach * VIEW / np.linalg.norm(VIEW), middle)


def _drawn_role(scene_graph: SceneGraph) -> Role | None:
    """What is meant to be seen, else what collides; None where a robot has neither."""
    inspector = scene_graph.model_inspector()
    roles = (Role.kIllustration, Role.kProximity)
    return next((role for role in roles if inspector.NumGeometriesWithRole(role)), None)
