"""Where parameters belong to bodies that can exist, as constraints of a nonlinear program."""

from __future__ import annotations

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot.inertia import pseudo_inertia

EDGE = 1e-9  # of a minor: beyond it a body has no extent


def possible_bodies(
    joints: int,
    parameters: Float[ndarray, " p"],
    half: Float[ndarray, "p r"],
    weights: Float[ndarray, "k p"],
    bounds: Float[ndarray, " k"],
) -> casadi.Function:
    """Map z to what must not be negative: leading minors of bodies' pseudo-inertias (Sylvester), demands.

    Where the first fit is at an edge it is let stay there.
    """
    z = casadi.SX.sym("z", half.shape[1])
    theta = casadi.DM(parameters) + casadi.mtimes(casadi.DM(half), z)
    slacks = [casadi.mtimes(casadi.DM(weights), theta) - casadi.DM(bounds)]
    basis = [pseudo_inertia(unit) for unit in np.eye(10)]
    for i in range(joints):
        # In units of its own diagonal, in which minors are numbers between 0 and 1.
        size = np.sqrt(np.diag(pseudo_inertia(parameters[10 * i : 10 * i + 10])))
        body = casadi.SX(4, 4)
        for k, J in enumerate(basis):
            body += theta[10 * i + k] * casadi.DM(J / np.outer(size, size))
        slacks += [casadi.det(body[:k, :k]) for k in range(1, 5)]
    every = casadi.vertcat(*slacks)
    first = np.array(casadi.Function("first", [z], [every])(0.0)).ravel()
    return casadi.Function("possible", [z], [every - casadi.DM(np.minimum(first, EDGE))])
