"""How far a joint's small turn can move the shapes that it carries, in any posture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.tree import BodyIndex, PrismaticJoint
from pydrake.multibody.tree import Joint as DrakeJoint
from pydrake.systems.framework import Context

from oed.design.scene import Scene

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def reaches(
    scene: Scene,
    context: Context,
    joints: Sequence[DrakeJoint],
    moved_by: Mapping[int, frozenset[int]],
    travel: Float[ndarray, " joints"],
) -> dict[int, Float[ndarray, " joints"]]:
    """Of every body, how far its furthest point moves per unit of each joint, at most.

    A point is no further from the axis of a joint than the way to it along the chain: the
    distances between consecutive joints, which no posture changes, and from the last of them to
    the furthest corner of the body's bounding boxes. Slides add their travel.

    Args:
        scene: With the plant and its shapes.
        context: Of the plant, all joints of the design at zero.
        joints: The n joints of the design.
        moved_by: For every body, which of these move it.
        travel: (n,) largest distance from zero of each [rad or m]; that of slides counts.

    Returns:
        (n,) reach of each body [m per rad; 1 per m of a slide], 0 of joints that do not move it.
    """
    origins = np.array([_origin(context, joint) for joint in joints]).reshape(-1, 3)
    is_slide = np.array([isinstance(joint, PrismaticJoint) for joint in joints])
    slack = np.where(is_slide, travel, 0.0)
    depth = _depth(joints, moved_by)
    found = {}
    for body, movers in moved_by.items():
        reach, way, ends = np.zeros(len(joints)), 0.0, _corners(scene, context, body)
        for joint in sorted(movers, key=lambda j: depth[j], reverse=True):  # from the body inward
            way += float(np.linalg.norm(ends - origins[joint], axis=1).max())
            reach[joint] = 1.0 if is_slide[joint] else way
            way += float(slack[joint])
            ends = origins[joint][None]
        found[body] = reach
    return found


def _depth(joints: Sequence[DrakeJoint], moved_by: Mapping[int, frozenset[int]]) -> dict[int, int]:
    """How many joints of the design move each joint's own body: its place along the chain."""
    return {i: len(moved_by[int(joint.child_body().index())]) for i, joint in enumerate(joints)}


def _origin(context: Context, joint: DrakeJoint) -> Float[ndarray, "3"]:
    """Where a joint is: on its axis, for one that turns."""
    frame = joint.frame_on_child()
    return np.asarray(frame.CalcPoseInWorld(context).translation())


def _corners(scene: Scene, context: Context, body: int) -> Float[ndarray, "corners 3"]:
    """The body's origin, and the corners of a box about each of its shapes, in the world."""
    inspector, moving = scene.scene_graph.model_inspector(), scene.plant.get_body(BodyIndex(body))
    X_WB = scene.plant.EvalBodyPoseInWorld(context, moving)
    found = [np.asarray(X_WB.translation())[None]]
    for geometry in scene.plant.GetCollisionGeometriesForBody(moving):
        box = inspector.GetObbInGeometryFrame(geometry)
        if box is None:  # a plane has no end
            found.append(np.full((1, 3), np.inf))
            continue
        X_WG = X_WB.multiply(inspector.GetPoseInFrame(geometry))
        p_GC = box.pose().multiply((CORNERS * box.half_width()).T)
        found.append(np.asarray(X_WG.multiply(p_GC)).T)
    return np.concatenate(found)
