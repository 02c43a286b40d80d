"""The paper's recursive Newton-Euler dynamics, for numbers and for symbols.

Forward recursion (1), backward recursion (2) and the regressor (4) of Calafiore, Indri
and Bona 2001, extended to prismatic joints, branching trees and any joint axis. Vectors of
body i are in its own frame, at its origin; gravity enters as the base acceleration -g.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.scalars import (
    ZERO,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    apply_transposed,
    cos,
    cross,
    dot,
    minus,
    mul,
    plus,
    scale,
    sin,
    total,
)
from oed.robot import Joint, Robot


@dataclass(frozen=True)
class BodyMotion:
    """Motion of one body frame relative to the base, in the body's own axes.

    Attributes:
        R_PJ: Axes of the frame in its parent's.
        p_PJ: Origin of the frame in its parent's [m].
        w: Angular velocity [rad/s].
        dw: Angular acceleration [rad/s^2].
        a: Acceleration of the origin less gravity [m/s^2].
    """

    R_PJ: Matrix
    p_PJ: Vector
    w: Vector
    dw: Vector
    a: Vector


def joint_pose(joint: Joint, q: Scalar) -> tuple[Matrix, Vector]:
    """Axes and origin of a body frame in its parent's at joint position q [rad or m]."""
    R_0 = _rows(joint.R_PJ)
    p_0 = _vector(joint.p_PJ)
    axis = _vector(joint.axis)
    if joint.kind == "prismatic":
        return R_0, plus(p_0, apply(R_0, scale(q, axis)))
    # Rodrigues: R v = c v + s (axis x v) + (1 - c) axis (axis . v), column by column.
    s, c = sin(q), cos(q)
    versine = 1.0 - c
    columns = []
    for unit in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        along = dot(axis, unit)
        if along * along == 1.0:
            columns.append(unit)
            continue
        turned = plus(scale(c, unit), scale(s, cross(axis, unit)))
        columns.append(plus(turned, scale(mul(along, versine), axis)))
    turned_columns = [apply(R_0, column) for column in columns]
    rows = tuple(tuple(column[r] for column in turned_columns) for r in range(3))
    return rows, p_0  # type: ignore[return-value]  # three rows of three by construction


def forward_recursion(
    robot: Robot, q: Sequence[Scalar], dq: Sequence[Scalar], ddq: Sequence[Scalar]
) -> list[BodyMotion]:
    """Velocities and accelerations of every body (1a-c), in joint order."""
    found: dict[int, BodyMotion] = {}
    for i in robot.outward:
        joint = robot.joints[i]
        R, p = joint_pose(joint, q[i])
        if joint.parent == -1:
            w_P, dw_P, a_P = ZERO, ZERO, _vector(-robot.gravity)
        else:
            parent = found[joint.parent]
            w_P, dw_P, a_P = parent.w, parent.dw, parent.a
        a_at_J = plus(a_P, plus(cross(dw_P, p), cross(w_P, cross(w_P, p))))
        w, dw, a = (apply_transposed(R, v) for v in (w_P, dw_P, a_at_J))
        axis = _vector(joint.axis)
        rate = scale(dq[i], axis)
        if joint.kind == "revolute":
            dw = plus(dw, plus(scale(ddq[i], axis), cross(w, rate)))
            w = plus(w, rate)
        else:
            coriolis = scale(2.0, cross(w, rate))
            a = plus(a, plus(scale(ddq[i], axis), coriolis))
        found[i] = BodyMotion(R, p, w, dw, a)
    return [found[i] for i in range(robot.n)]


def inverse_dynamics(
    robot: Robot,
    q: Sequence[Scalar],
    dq: Sequence[Scalar],
    ddq: Sequence[Scalar],
) -> list[Scalar]:
    """Joint torques (2a-c) without friction, for the robot's own parameters [N m or N]."""
    bodies = forward_recursion(robot, q, dq, ddq)
    forces: list[Vector] = [ZERO] * robot.n
    moments: list[Vector] = [ZERO] * robot.n
    torques: list[Scalar] = [0.0] * robot.n
    for i in reversed(robot.outward):
        body, joint = bodies[i], robot.joints[i]
        force, moment = _inertial_wrench(robot.parameters[10 * i : 10 * i + 10], body)
        force, moment = plus(force, forces[i]), plus(moment, moments[i])
        torques[i] = dot(_vector(joint.axis), moment if joint.kind == "revolute" else force)
        if joint.parent >= 0:
            at_parent = apply(body.R_PJ, force)
            turned = plus(apply(body.R_PJ, moment), cross(body.p_PJ, at_parent))
            forces[joint.parent] = plus(forces[joint.parent], at_parent)
            moments[joint.parent] = plus(moments[joint.parent], turned)
    return torques


def regressor_entries(
    robot: Robot,
    q: Sequence[Scalar],
    dq: Sequence[Scalar],
    ddq: Sequence[Scalar],
    links: Collection[int] | None = None,
) -> list[dict[int, Scalar]]:
    """Torque per unit of each standard parameter: for column c, joint -> entry (4).

    The axis of every joint on the path is carried outward as a screw (angular part,
    linear part at the body's origin) and meets the wrench of a unit parameter there:
    no 6 x 10 matrix is ever sent back along the chain. Columns of other links than `links`,
    if given, stay empty.
    """
    bodies = forward_recursion(robot, q, dq, ddq)
    columns: list[dict[int, Scalar]] = [{} for _ in range(10 * robot.n)]
    screws: dict[int, dict[int, tuple[Vector, Vector]]] = {-1: {}}
    for i in robot.outward:
        body, joint = bodies[i], robot.joints[i]
        axis = _vector(joint.axis)
        carried = {
            j: (
                apply_transposed(body.R_PJ, angular),
                apply_transposed(body.R_PJ, plus(linear, cross(angular, body.p_PJ))),
            )
            for j, (angular, linear) in screws[joint.parent].items()
        }
        carried[i] = (axis, ZERO) if joint.kind == "revolute" else (ZERO, axis)
        screws[i] = carried
        if links is not None and i not in links:
            continue
        for j, (angular, linear) in carried.items():
            for k, entry in enumerate(_screw_on_unit_wrenches(angular, linear, body)):
                columns[10 * i + k][j] = entry
    return columns


def rigid_body_regressor(robot: Robot, motion: Motion) -> Float[ndarray, "samples joints standard"]:
    """The regressor of the 10 n standard parameters at every instant of a motion."""
    return filled(regressor_entries(robot, *motion.components), len(motion), robot.n)


def filled(
    entries: Sequence[Mapping[int, Scalar]], samples: int, joints: int
) -> Float[ndarray, "samples joints columns"]:
    """Columns from their entries, joint -> (N,) array or number, zero where there is none."""
    columns = np.zeros((samples, joints, len(entries)))
    for column, by_joint in enumerate(entries):
        for joint, entry in by_joint.items():
            columns[:, joint, column] = entry
    return columns


def rigid_body_torque(robot: Robot, motion: Motion) -> Float[ndarray, "samples joints"]:
    """Torque of the robot's own parameters by the recursion (2) [N m or N]."""
    torques = inverse_dynamics(robot, *motion.components)
    return np.stack([np.broadcast_to(torque, len(motion)) for torque in torques], axis=1)


def _inertial_wrench(parameters: Float[ndarray, "10"], body: BodyMotion) -> tuple[Vector, Vector]:
    """Force and moment that the body needs at its origin (2a-b, first and last terms)."""
    mass = float(parameters[0])
    h = _vector(parameters[1:4])
    xx, xy, xz, yy, yz, zz = (float(x) for x in parameters[4:])
    inertia: Matrix = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    whirl = plus(cross(body.dw, h), cross(body.w, cross(body.w, h)))
    force = plus(scale(mass, body.a), whirl)
    gyroscopic = cross(body.w, apply(inertia, body.w))
    moment = plus(plus(apply(inertia, body.dw), gyroscopic), cross(h, body.a))
    return force, moment


def _screw_on_unit_wrenches(angular: Vector, linear: Vector, body: BodyMotion) -> list[Scalar]:
    """Power of a joint's unit screw against the wrench of each unit parameter."""
    w, dw, a = body.w, body.dw, body.a
    centripetal = minus(scale(dot(linear, w), w), scale(dot(w, w), linear))
    first_moment = plus(plus(cross(linear, dw), centripetal), cross(a, angular))
    swept = cross(angular, w)
    (ax, ay, az), (dx, dy, dz), (wx, wy, wz), (ux, uy, uz) = angular, swept, w, dw
    return [
        dot(linear, a),
        *first_moment,
        add(mul(ax, ux), mul(dx, wx)),
        total([mul(ax, uy), mul(ay, ux), mul(dx, wy), mul(dy, wx)]),
        total([mul(ax, uz), mul(az, ux), mul(dx, wz), mul(dz, wx)]),
        add(mul(ay, uy), mul(dy, wy)),
        total([mul(ay, uz), mul(az, uy), mul(dy, wz), mul(dz, wy)]),
        add(mul(az, uz), mul(dz, wz)),
    ]


def _vector(entries: Float[ndarray, "3"]) -> Vector:
    x, y, z = (float(entry) for entry in entries)
    return (x, y, z)


def _rows(entries: Float[ndarray, "3 3"]) -> Matrix:
    return (_vector(entries[0]), _vector(entries[1]), _vector(entries[2]))
