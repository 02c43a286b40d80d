"""How near a motion brings the arm to itself and to its walls.

A check is made at instants and is no proof: it says how near the arm came, and when.
"""

from __future__ import annotations

from dataclasses import dataclass

from oed.design.collision import FAR, Pair, Surroundings, is_wall
from oed.design.status import LimitStatus, Standing
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
        has_shapes: Whether bodies were looked at.
        least_to_wall: Least distance of a body's origin to a wall of the box [m]; negative beyond
            it, None where there is no box or nothing came within `FAR`.
        least_of_bodies: Likewise of two bodies.
    """

    least: float | None
    pair: Pair | None
    time: float | None
    instants: int
    note: str
    missing_shapes: int = 0
    has_shapes: bool = False
    least_to_wall: float | None = None
    least_of_bodies: float | None = None

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
    least: dict[bool, tuple[float, Pair | None, float | None]] = dict.fromkeys(
        (False, True), (FAR, None, None)
    )
    for t, q in zip(motion.t, motion.q, strict=True):
        for near, distance in surroundings.distances(q).items():
            side = is_wall(near)
            if distance < least[side][0]:
                least[side] = (distance, near, float(t))
    distance, pair, time = min(least.values(), key=lambda found: found[0])
    bodies, wall = (d if near else None for d, near, _ in (least[False], least[True]))
    return ClearanceCheck(
        distance if pair else None,
        pair,
        time,
        len(motion),
        surroundings.note,
        surroundings.missing_shapes,
        surroundings.has_shapes,
        wall,
        bodies,
    )


def clearance_status(
    check: ClearanceCheck, *, is_asked: bool, has_box: bool
) -> tuple[LimitStatus, ...]:
    """What a check says of the arm's distance to itself, and to its box.

    Args:
        check: Of the motion.
        is_asked: Whether the user asked for an arm clear of itself.
        has_box: Whether there is a box to be kept.
    """
    bodies = LimitStatus("clear of itself", *_of_bodies(check, is_asked), is_demanded=is_asked)
    if not has_box:
        return (bodies,)
    if check.instants == 0:
        return bodies, LimitStatus("the box", "not checked", check.note, is_demanded=True)
    least = check.least_to_wall
    if least is not None and least <= 0.0:
        evidence = f"left by {-least:.3g} m"
        return bodies, LimitStatus("the box", "not kept", evidence, is_demanded=True)
    evidence = f"origins of bodies at {check.instants} instants"
    return bodies, LimitStatus("the box", "checked", evidence, is_demanded=True)


def _of_bodies(check: ClearanceCheck, is_asked: bool) -> tuple[Standing, str]:
    least = check.least_of_bodies
    if least is not None and least <= 0.0:
        evidence = f"bodies overlap by {-least * 1e3:.1f} mm"
        return ("not kept" if is_asked else "given up"), evidence
    if check.instants == 0 or not check.has_shapes:
        return "not checked", check.note.removeprefix("not checked: ")
    if check.missing_shapes:
        return "not checked", f"the meshes of {check.missing_shapes} shapes are missing"
    nearest = f"more than {FAR:g} m" if least is None else f"at least {least * 1e3:.1f} mm"
    return "checked", f"{nearest} at {check.instants} instants"
