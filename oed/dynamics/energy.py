"""The energy model: the paper's second, acceleration-free formulation.

The work of the joint torques between two instants is the change of kinetic and potential
energy plus the work of every other effect: integral of q'^T tau dt = h(t_b) - h(t_a) + ...
Linear in the same parameters as the torque model, it needs neither ddq nor a filter on it
(Gautier and Khalil 1990; Calafiore 2001, end of section 2).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import joint_pose
from oed.dynamics.scalars import (
    ZERO,
    Scalar,
    Vector,
    apply_transposed,
    cross,
    dot,
    minus,
    mul,
    plus,
    scale,
)
from oed.robot import Robot


def energy_entries(robot: Robot, q: Sequence[Scalar], dq: Sequence[Scalar]) -> list[Scalar]:
    """Total energy per unit of each of the 10 n standard parameters [J per unit]."""
    gravity: Vector = tuple(float(g) for g in robot.gravity)  # type: ignore[assignment]
    # Per body: angular and linear velocity of its origin, gravity in its axes, and height
    # of its origin against gravity.
    states: dict[int, tuple[Vector, Vector, Vector, Scalar]] = {-1: (ZERO, ZERO, gravity, 0.0)}
    entries: dict[int, list[Scalar]] = {}
    for i in robot.outward:
        joint = robot.joints[i]
        w_P, v_P, g_P, potential_P = states[joint.parent]
        R, p = joint_pose(joint, q[i])
        w = apply_transposed(R, w_P)
        v = apply_transposed(R, plus(v_P, cross(w_P, p)))
        axis: Vector = tuple(float(x) for x in joint.axis)  # type: ignore[assignment]
        rate = scale(dq[i], axis)
        if joint.kind == "revolute":
            w = plus(w, rate)
        else:
            v = plus(v, rate)
        g = apply_transposed(R, g_P)
        potential = potential_P - dot(g_P, p)
        states[i] = (w, v, g, potential)
        entries[i] = [
            0.5 * dot(v, v) + potential,
            *minus(cross(v, w), g),
            *_rotational(w),
        ]
    return [entry for i in range(robot.n) for entry in entries[i]]


def energy_regressor(robot: Robot, motion: Motion) -> Float[ndarray, "samples standard"]:
    """Total energy of each unit parameter at every instant; `motion.ddq` is not used."""
    q, dq, _ = motion.components
    entries = energy_entries(robot, q, dq)
    return np.stack([np.broadcast_to(entry, len(motion)) for entry in entries], axis=1)


def _rotational(w: Vector) -> list[Scalar]:
    x, y, z = w
    return [
        0.5 * mul(x, x),
        mul(x, y),
        mul(x, z),
        0.5 * mul(y, y),
        mul(y, z),
        0.5 * mul(z, z),
    ]
