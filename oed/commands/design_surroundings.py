"""What the motion of `oed design` is held clear of: the arm itself, and the walls of a box."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.configurations import Design
from oed.design.collision import Surroundings
from oed.errors import OedError, RobotError
from oed.robot import Robot


def surroundings_of(robot: Robot, config: Design) -> tuple[Surroundings | None, str]:
    """What may be hit; None with the reason where the robot has no geometry."""
    clearance = config.clearance if not config.no_clearance else 0.0
    try:
        return Surroundings(robot, _walls(config) if config.box else None, clearance), ""
    except OedError as error:
        return None, f"not checked: {error}"


def kept_clear_of(
    surroundings: Surroundings | None, robot: Robot, config: Design
) -> Surroundings | None:
    """What the motion must keep clear of; None where there is nothing."""
    has_shapes = surroundings is not None and surroundings.has_shapes
    if config.avoid_collision and not has_shapes:
        reason = "it has no file" if surroundings is None else surroundings.note
        raise RobotError(f"--avoid-collision: {reason}")
    if surroundings is None:
        if config.box:
            raise RobotError(f"--box: {robot.name} does not come from a file: it has no geometry")
        return None
    if not config.no_clearance:
        return surroundings if has_shapes or config.box else None
    return Surroundings(robot, _walls(config), walls_only=True) if config.box else None


def _walls(config: Design) -> Float[ndarray, "3 2"]:
    """The box as lower and upper bounds of x, y, z; empty where there is none."""
    return np.array(config.box or ()).reshape(-1, 2)
