"""A robot as lines between its joints, for one that has no shapes to show."""

# pydrake's stubs want float64 arrays where ndarray is given.
# pyright: reportArgumentType=false, reportCallIssue=false

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import Box, Cylinder, Rgba, Shape
from pydrake.math import RigidTransform, RotationMatrix

from oed.dynamics.newton_euler import joint_pose
from oed.report.colours import BLUE, GREY
from oed.robot import Robot

# Of the longest line, as is usual of an arm's links; of a robot of one point, in metres.
THICKNESS = 0.05
ALONE = 0.2  # [m]
WORLD = -1


@dataclass(frozen=True)
class Part:
    """A shape that moves with a body.

    Attributes:
        body: Index of the joint whose body carries it, -1 for the base.
        shape: In its own frame.
        place: Of that frame in the body's.
        colour: To draw it in.
        size: (3,) half the edges of the box around it, in its own frame [m].
    """

    body: int
    shape: Shape
    place: RigidTransform
    colour: Rgba
    size: Float[ndarray, "3"]


def skeleton(robot: Robot) -> list[Part]:
    """Lines and joints: a cylinder along the axis of one that turns, a box at one that slides.

    A line leads from each body to those that it carries, and from the last to its centre of mass.
    """
    lines = [line for line in _lines(robot) if np.linalg.norm(line[2] - line[1]) > 0]
    longest = max((float(np.linalg.norm(end - start)) for _, start, end in lines), default=ALONE)
    radius = THICKNESS * longest
    parts = [_rod(body, start, end, radius) for body, start, end in lines]
    for i, joint in enumerate(robot.joints):
        turned = RotationMatrix.MakeFromOneVector(joint.axis, axis_index=2)
        place, height, width = RigidTransform(turned, np.zeros(3)), 3 * radius, 1.5 * radius
        drawn = (
            Cylinder(width, height)
            if joint.kind == "revolute"
            else Box(2 * width, 2 * width, height)
        )
        half = np.array([width, width, height / 2])
        parts.append(Part(i, drawn, place, _colour(BLUE), half))
    return parts


def body_poses(robot: Robot, q: Float[ndarray, " joints"]) -> dict[int, RigidTransform]:
    """Where every body is in the base frame, by the index of its joint; the base too.

    Args:
        robot: The robot.
        q: (n,) positions of its joints [rad or m].
    """
    poses = {WORLD: RigidTransform()}
    for i in robot.outward:
        rotation, origin = joint_pose(robot.joints[i], float(q[i]))
        turned = RotationMatrix.ProjectToRotationMatrix(np.array(rotation))  # of rounded axes
        own = RigidTransform(turned, np.array(origin))
        poses[i] = poses[robot.joints[i].parent] @ own
    return poses


def _lines(robot: Robot) -> Iterator[tuple[int, ndarray, ndarray]]:
    """Body, start and end of each line, in the body's frame [m]."""
    origin = np.zeros(3)
    carriers = {joint.parent for joint in robot.joints}
    for i, joint in enumerate(robot.joints):
        yield joint.parent, origin, np.asarray(joint.p_PJ)
        if joint.kind == "prismatic":  # what slides hangs on a rail
            reach = np.nan_to_num(robot.limits.position[i], posinf=0.0, neginf=0.0)
            low, high = (joint.p_PJ + joint.R_PJ @ (joint.axis * end) for end in reach)
            yield joint.parent, low, high
        mass, *moment = robot.parameters[10 * i : 10 * i + 4]
        if i not in carriers and mass > 0:
            yield i, origin, np.array(moment) / mass


def _rod(body: int, start: ndarray, end: ndarray, radius: float) -> Part:
    length = float(np.linalg.norm(end - start))
    turned = RotationMatrix.MakeFromOneVector((end - start) / length, axis_index=2)
    place = RigidTransform(turned, (start + end) / 2)
    half = np.array([radius, radius, length / 2])
    return Part(body, Cylinder(radius, length), place, _colour(GREY), half)


def _colour(web: str) -> Rgba:
    red, green, blue = (int(web[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return Rgba(red, green, blue, 1.0)
