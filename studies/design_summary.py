"""What `studies.design` prints of a design."""

from __future__ import annotations

from collections.abc import Sequence

from oed.design.bound.efficiency import DEfficiency
from oed.design.clearance import ClearanceCheck
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
    size = f"{problem.model.robot.n} joints, {len(problem.base)} base parameters"
    rows = f"{len(problem.instants)} instants, {problem.rows} rows"
    spare = -design.certificate.violation
    lines = [
        f"{problem.model.robot.name}: {size}, {rows}",
        f"  status  {design.status}",
        f"  {sampled} ({elsewhere})",
        f"  J_d = log10 det Lambda  {design.J_d:.4f} (continuous {design.J_d_continuous:.4f})",
        f"  nearest limit  {design.certificate.worst}, proven {spare:.2e} of it to spare",
        f"  D-efficiency  {_efficiency_line(efficiency)}",
        f"  clearance  {_clearance_line(clearance)}",
        f"  {design.evaluations} evaluations in {design.cpu_s:.1f} s of CPU time",
    ]
    return "\n".join(lines + [f"  note: {note}" for note in notes])


def _efficiency_line(efficiency: DEfficiency | None) -> str:
    if efficiency is None:
        return "not known"
    return f"at least {efficiency.value:.3f}, {efficiency.kind}"


def _clearance_line(clearance: ClearanceCheck) -> str:
    missing = clearance.missing_shapes
    unchecked = f"not checked for want of the meshes of {missing} collision shapes; "
    if clearance.instants == 0:
        return f"{unchecked if missing else ''}{clearance.note}"
    if clearance.least is None or clearance.pair is None or clearance.time is None:
        nothing = f"nothing comes near at {clearance.instants} instants; "
        return f"{unchecked if missing else nothing}{clearance.note}".rstrip("; ")
    pair = " and ".join(clearance.pair)
    distance = f"{abs(clearance.least) * 1e3:.1f} mm at {clearance.time:.2f} s"
    if clearance.least > 0.0:
        of_some = f"{unchecked}of the others " if missing else ""
        found = f"{of_some}least {distance}, {pair} ({clearance.instants} instants)"
    else:
        found = f"{pair} overlap by {distance}: use --avoid-collision or narrow the limits"
    return f"{found}; {clearance.note}".rstrip("; ")
