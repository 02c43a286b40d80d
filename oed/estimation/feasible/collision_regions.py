"""Where the mass of each link can be: a box around its collision geometry."""

from __future__ import annotations

import itertools

import numpy as np
import pinocchio
from jaxtyping import Float
from numpy import ndarray

from oed.errors import RobotError
from oed.estimation.feasible.feasible_set import MassRegion
from oed.robot import Robot, described
from oed.robot.pinocchio_pose import held_displacement, pinocchio_model

# Covers and cables stick out of a collision shape by about this much.
CLEARANCE = 0.01  # [m]
PACKAGE_DEPTH = 5  # folders above a robot file in which its package may lie
CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))


def collision_regions(robot: Robot, *, clearance: float = CLEARANCE) -> tuple[MassRegion, ...]:
    """A box in the body frame around all collision shapes that each joint carries.

    Read by Pinocchio, which knows all common kinds of mesh. Links whose file states no collision
    shape get none; what hangs on a joint that the robot holds is where that joint is held.

    Args:
        robot: Loaded from a URDF file.
        clearance: Added on all sides [m].

    Raises:
        RobotError: If the robot came from no URDF file, or its shapes cannot be read.
    """
    try:
        file = described(robot)
    except RobotError as error:
        raise RobotError(f"{error}: there is no collision geometry to keep its mass in") from error
    if file.format != "urdf":
        raise RobotError(f"{robot.source!r}: collision geometry is read from a URDF file")
    path, model = file.place, pinocchio_model(file)
    # package://NAME/ is a folder of that name above the file.
    folders = [str(folder) for folder in itertools.islice(path.resolve().parents, PACKAGE_DEPTH)]
    try:
        shapes = pinocchio.buildGeomFromUrdfString(
            model, file.text, pinocchio.GeometryType.COLLISION, package_dirs=folders
        )
    except (ValueError, RuntimeError) as error:
        raise RobotError(f"{path}: its shapes cannot be read: {error}") from error
    found: dict[int, list[ndarray]] = {}
    for link, corners in _corners(model, shapes, robot):
        found.setdefault(link, []).append(corners)
    return tuple(
        MassRegion.box(
            link,
            np.concatenate(corners).min(axis=0) - clearance,
            np.concatenate(corners).max(axis=0) + clearance,
            name="collision box",
        )
        for link, corners in sorted(found.items())
    )


def _corners(
    model: pinocchio.Model, shapes: pinocchio.GeometryModel, robot: Robot
) -> list[tuple[int, Float[ndarray, "8 3"]]]:
    """Corners of each moving shape's box, in the frame of the body that carries it [m]."""
    data = model.createData()
    posture = pinocchio.integrate(model, pinocchio.neutral(model), held_displacement(model, robot))
    pinocchio.forwardKinematics(model, data, posture)
    column = {model.getJointId(name): i for i, name in enumerate(robot.joint_names)}
    corners = []
    for shape in shapes.geometryObjects:
        carrier = shape.parentJoint
        while carrier and carrier not in column:
            carrier = model.parents[carrier]
        if not carrier:
            continue
        joint = robot.joints[column[carrier]]
        in_world = data.oMi[carrier] * pinocchio.SE3(joint.R_LJ, joint.p_LJ)
        pose = in_world.actInv(data.oMi[shape.parentJoint] * shape.placement)
        shape.geometry.computeLocalAABB()
        box = shape.geometry.aabb_local
        bounds = np.array([np.ravel(box.min_), np.ravel(box.max_)])
        points = bounds[CORNERS, np.arange(3)]
        corners.append((column[carrier], points @ pose.rotation.T + pose.translation))
    return corners
