"""What `oed design` prints of a design."""

from __future__ import annotations

from collections.abc import Sequence

from oed.counted import counted
from oed.design.bound.efficiency import DEfficiency
from oed.design.clearance import ClearanceCheck, Nearest
from oed.design.design import Design


def summary(
    design: Design,
    efficiency: DEfficiency | None,
    clearance: ClearanceCheck,
    notes: Sequence[str],
) -> str:
    """A few lines for the screen.

    Args:
        design: The motion.
        efficiency: What it is worth against a bound; None where that is not known.
        clearance: What the geometry says of it.
        notes: What was assumed or left out, a line each.
    """
    problem = design.problem
    sampled = f"J_k = cond Lambda  {design.J_k:.4g}"
    scaled = design.J_k_scaled
    elsewhere = f"continuous {design.J_k_continuous:.4g}" + (
        "" if scaled is None else f"; J_k_scaled {scaled:.4g}"
    )
    joints = counted(problem.model.robot.n, "joint")
    size = f"{joints}, {counted(len(problem.base), 'base parameter')}"
    rows = f"{counted(len(problem.instants), 'instant')}, {counted(problem.rows, 'row')}"
    lines = [
        f"{problem.model.robot.name}: {size}, {rows}",
        f"  status  {design.status}",
        f"  {sampled} ({elsewhere})",
        f"  J_d = log10 det Lambda  {design.J_d:.4f} (continuous {design.J_d_continuous:.4f})",
        f"  nearest limit  {design.certificate.nearest}",
        f"  D-efficiency  {efficiency_line(efficiency)}",
        f"  clearance  {clearance_line(clearance)}",
        f"  {counted(design.evaluations, 'evaluation')} in {design.cpu_s:.1f} s of CPU time",
    ]
    return "\n".join(lines + [f"  note: {note}" for note in notes])


def efficiency_line(efficiency: DEfficiency | None) -> str:
    """What a design is worth against a bound, in words."""
    if efficiency is None:
        return "not known"
    if efficiency.kind == "certified":
        return f"at least {efficiency.value:.3f}, certified"
    return f"about {efficiency.value:.3f}: the bound is estimated, not proven"


def clearance_line(check: ClearanceCheck) -> str:
    """How near the arm comes to itself and to its walls, in words."""
    if check.instants == 0:
        return check.note
    parts = [_of_kind(found) for found in (check.bodies, check.walls) if found is not None]
    looked = f"{check.instants} instants, and all times between them"
    unknown = f"nothing is known of {', '.join(check.missing)}" if check.missing else ""
    return "; ".join(filter(None, (*parts, looked, unknown, check.note)))


def _of_kind(found: Nearest) -> str:
    if found.least is None or found.pair is None or found.time is None:
        return "nothing comes near"
    pair, distance = " and ".join(found.pair), 1e3 * abs(found.least)
    if found.least <= 0.0:
        return f"{pair} overlap by {distance:.1f} mm at {found.time:.2f} s"
    return f"least {distance:.1f} mm, {pair} at {found.time:.2f} s"
