"""A model's bodies, friction and rotors as SDF, with the robot's own shapes and limits."""

from __future__ import annotations

from oed.export.bodies import calibrated_robot, gravity_note, not_in_file
from oed.export.model import Model
from oed.export.registry import Exported, Target
from oed.export.round_trip import require_round_trip, some_states
from oed.export.sdf import write_sdf
from oed.export.shapes import collect_shapes


def write(model: Model, target: Target) -> Exported:
    """Write robot.sdf, and load it again: its torques are the model's."""
    calibrated = calibrated_robot(model)
    shapes = collect_shapes(model.robot, target.folder)
    path = write_sdf(calibrated, target.folder / "robot.sdf", shapes=shapes)
    require_round_trip(calibrated, path, some_states(model.robot))
    notes = (*filter(None, [shapes.note]), *gravity_note(model, "SDF"))
    return Exported((path.name,), "SDF, as it is", not_in_file(model, "SDF"), notes)
