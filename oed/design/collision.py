"""Whether a motion keeps the arm off itself and within a box, by Drake's geometry.

A check at many instants, not a proof: it says how near the arm came, and when.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from oed.design.scene import Scene, load_scene
from oed.dynamics.motion import Motion
from oed.errors import OedError
from oed.robot import Robot


@dataclass(frozen=True)
class ClearanceCheck:
    """What the check found.

    Attributes:
        deepest: Largest penetration of two bodies that are free of each other at the rest
            position [m]; 0 where none touch. None where there is no geometry to check.
        pair: Names of those bodies.
        time: When [s].
        outside: Largest distance of a body's origin outside the workspace box [m]; None
            without a box.
        instants: Number of instants looked at.
        note: What could not be checked.
    """

    deepest: float | None
    pair: tuple[str, str] | None
    time: float | None
    outside: float | None
    instants: int
    note: str

    @property
    def is_clear(self) -> bool:
        """Whether the check was made and found nothing; False where there was no geometry."""
        return self.deepest == 0.0 and not (self.outside is not None and self.outside > 0)


def check_clearance(
    robot: Robot, motion: Motion, box: Float[ndarray, "3 2"] | None = None
) -> ClearanceCheck:
    """Look for self-collision, and for bodies outside a box, at every instant of a motion.

    Pairs of bodies whose shapes overlap at the middle of the limits already are left out, as
    are those that Drake filters (a body and the one it is mounted on).

    Args:
        robot: Loaded from a file.
        motion: At the instants to check.
        box: Lower and upper bound of x, y, z in the base frame [m]; None for no box.
    """
    try:
        scene = load_scene(robot)
    except OedError as error:
        return ClearanceCheck(None, None, None, None, 0, f"not checked: {error}")
    diagram = scene.builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = scene.plant.GetMyMutableContextFromRoot(context)
    rest = scene.plant.GetPositions(plant_context).copy()
    limits = robot.limits.position
    middle = np.where(np.isfinite(limits).all(axis=1), limits.mean(axis=1), 0.0)
    scene.plant.SetPositions(plant_context, scene.positions(middle, rest))
    ignored = {pair for pair, _ in _contacts(scene, plant_context)}
    worst: tuple[float, tuple[str, str] | None, float | None] = (0.0, None, None)
    outside = None if box is None else 0.0
    for t, q in zip(motion.t, motion.q, strict=True):
        scene.plant.SetPositions(plant_context, scene.positions(q, rest))
        for pair, depth in _contacts(scene, plant_context):
            if pair not in ignored and depth > worst[0]:
                worst = (depth, pair, float(t))
        if box is not None and outside is not None:
            outside = max(outside, _beyond(scene.plant, plant_context, box))
    note = scene.note
    if ignored:
        note = f"{note}; {len(ignored)} pairs that overlap at mid-range are not judged".lstrip("; ")
    if scene.scene_graph.model_inspector().num_geometries() == 0:
        return ClearanceCheck(None, None, None, outside, len(motion), note or "no geometry")
    return ClearanceCheck(*worst, outside, len(motion), note)


def _contacts(
    scene: Scene, plant_context
) -> list[tuple[tuple[str, str], float]]:  # pydrake's Context has no stable import path
    """Pairs of bodies whose collision shapes overlap, and how deep [m]."""
    port = scene.plant.get_geometry_query_input_port()
    query = port.Eval(plant_context)
    inspector = query.inspector()

    def body(geometry) -> str:  # a GeometryId
        return scene.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).name()

    return [
        ((min(a, b), max(a, b)), float(found.depth))
        for found in query.ComputePointPairPenetration()
        for a, b in [(body(found.id_A), body(found.id_B))]
    ]


def _beyond(plant: MultibodyPlant, plant_context, box: ndarray) -> float:  # as above
    origins = [
        plant.EvalBodyPoseInWorld(plant_context, plant.get_body(BodyIndex(i))).translation()
        for i in range(1, plant.num_bodies())
    ]
    over = np.maximum(box[:, 0] - origins, origins - box[:, 1])
    return float(np.maximum(over, 0.0).max())
