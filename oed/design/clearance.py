"""How near a motion brings the arm to itself and to its walls.

A check is made at instants and is no proof: it says how near the arm came, and when.
"""

from __future__ import annotations

from dataclasses import dataclass

from oed.design.collision import FAR, Pair, Surroundings
from oed.dynamics.motion import Motion


@dataclass(frozen=True)
class ClearanceCheck:
    """What a check found.

    Attributes:
        least: Least distance of two bodies, or of a body and a wall [m]; negative where they
            overlap. None where there is nothing to check, or where nothing came within `FAR`.
        pair: Names of those two.
        time: When [s].
        instants: Number of instants looked at.
        note: What could not be checked, or is not judged.
        missing_shapes: Collision shapes whose meshes are missing: the check says nothing of them.
    """

    least: float | None
    pair: Pair | None
    time: float | None
    instants: int
    note: str
    missing_shapes: int = 0

    @classmethod
    def not_made(cls, reason: str, missing_shapes: int = 0) -> ClearanceCheck:
        """Of nothing, and why."""
        return cls(None, None, None, 0, reason, missing_shapes)

    @property
    def is_clear(self) -> bool:
        """Whether the check was made of every shape and nothing overlaps."""
        is_apart = self.least is None or self.least > 0.0
        return self.instants > 0 and self.missing_shapes == 0 and is_apart


def check_clearance(surroundings: Surroundings, motion: Motion) -> ClearanceCheck:
    """Look for the least distance at every instant of a motion."""
    if not surroundings.has_shapes and surroundings.box is None:
        return ClearanceCheck.not_made(surroundings.note, surroundings.missing_shapes)
    least, pair, time = FAR, None, None
    for t, q in zip(motion.t, motion.q, strict=True):
        for near, distance in surroundings.distances(q).items():
            if distance < least:
                least, pair, time = distance, near, float(t)
    found = least if pair else None
    missing = surroundings.missing_shapes
    return ClearanceCheck(found, pair, time, len(motion), surroundings.note, missing)
