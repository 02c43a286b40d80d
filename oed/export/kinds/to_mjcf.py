"""A model's bodies, friction and rotors as MJCF, with the robot's own shapes and limits."""

from __future__ import annotations

from oed.export.bodies import calibrated_robot, not_in_file
from oed.export.mjcf import write_mjcf
from oed.export.model import Model
from oed.export.registry import Exported, Target
from oed.export.round_trip import require_round_trip, some_states
from oed.export.shapes import collect_shapes


def write(model: Model, target: Target) -> Exported:
    """Write robot.xml, and load it again: its torques are the model's."""
    calibrated = calibrated_robot(model)
    shapes = collect_shapes(model.robot, target.folder)
    path = write_mjcf(calibrated, target.folder / "robot.xml", shapes=shapes)
    require_round_trip(calibrated, path, some_states(model.robot))
    notes = tuple(filter(None, [shapes.note]))
    return Exported((path.name,), "MJCF, as it is", not_in_file(model, "MJCF"), notes)
