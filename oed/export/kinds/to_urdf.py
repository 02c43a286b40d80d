"""A model's bodies, friction and rotors as URDF, with the robot's own shapes and limits."""

from __future__ import annotations

from oed.export.bodies import calibrated_robot, gravity_note, not_in_file
from oed.export.model import Model
from oed.export.registry import Exported, Target
from oed.export.round_trip import require_round_trip, some_states
from oed.export.shapes import collect_shapes
from oed.export.urdf import NO_SHAPES, write_urdf


def write(model: Model, target: Target) -> Exported:
    """Write robot.urdf, and load it again: its torques are the model's."""
    calibrated = calibrated_robot(model)
    file = model.robot.description
    kept = file is not None and file.format == "urdf"  # which is edited, its own shapes in it
    shapes = NO_SHAPES if kept else collect_shapes(model.robot, target.folder)
    path = write_urdf(calibrated, target.folder / "robot.urdf", shapes=shapes, home=target.home)
    require_round_trip(calibrated, path, some_states(model.robot))
    notes = (*filter(None, [shapes.note]), *gravity_note(model, "URDF"))
    return Exported((path.name,), "URDF, as it is", not_in_file(model, "URDF"), notes)
