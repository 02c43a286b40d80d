"""A feasible calibration as rows: parameters, links and residuals."""

from __future__ import annotations

import numpy as np

from oed.estimation.feasible.calibration import FeasibleCalibration
from oed.estimation.feasible.change_from_file import LinkChange
from oed.report.table import Row


def parameter_rows(result: FeasibleCalibration) -> list[Row]:
    """One row for each standard parameter and each effect's.

    What the data do not decide has no interval: its value is the reference's, and so is its spread.
    """
    estimate, interval = result.estimate, result.bootstrap.interval()
    at_bound = estimate.at_bound
    return [
        {
            "name": name,
            "unit": estimate.units[k],
            "value": float(estimate.parameters[k]),
            "lower95": _finite(interval[k, 0]),
            "upper95": _finite(interval[k, 1]),
            "from_data": float(estimate.from_data[k]),
            "at_bound": bool(at_bound[k]),
            "reference": float(estimate.reference[k]) if k < len(estimate.reference) else None,
        }
        for k, name in enumerate(estimate.names)
    ]


def solver_comparison(result: FeasibleCalibration) -> str:
    """Whether another solver came to the same objective, in words."""
    solution = result.estimate.solution
    if result.disagreement is None:
        passed = "passed" if solution.is_accurate else "did not pass"
        return (
            f"Solved by {solution.solver}, which {passed} its check; the other solver, tried for "
            f"comparison, failed ({result.second_failure})."
        )
    return f"Objectives of the two solvers differ by {result.disagreement:.1e}, relatively."


def link_rows(result: FeasibleCalibration) -> list[Row]:
    """One row a link: mass, centre and margins."""
    estimate = result.estimate
    robot = estimate.robot
    return [
        {
            "link": joint.link,
            "mass [kg]": float(m),
            "x [m]": float(mx / m),
            "y [m]": float(my / m),
            "z [m]": float(mz / m),
            "least eigenvalue": float(estimate.margins[i]),
            "per reference": float(estimate.relative_margins[i]),
            "at the bound": f"consistency of {joint.link}" in estimate.active,
        }
        for i, (joint, (m, mx, my, mz, *_)) in enumerate(
            zip(robot.joints, robot.parameters.reshape(-1, 10), strict=True)
        )
    ]


def change_rows(result: FeasibleCalibration) -> list[Row]:
    """One row a link and one for the total mass: in the file, as identified, and the change."""
    return [_change_row(change) for change in result.changes]


def _change_row(change: LinkChange) -> Row:
    mass, inertia = change.mass, change.inertia
    displacement = [moved.after - moved.before for moved in change.centre]
    spread = float(np.linalg.norm([moved.deviation for moved in change.centre]))
    row: dict[str, str | float | bool | None] = {
        "link": change.link,
        "file [kg]": mass.before,
        "identified [kg]": mass.after,
        "change [%]": 100 * (mass.after / mass.before - 1),
        "lower95 [kg]": float(mass.interval[0]),
        "upper95 [kg]": float(mass.interval[1]),
        "data alone +- [kg]": _finite(mass.deviation),
        "centre moved [m]": float(np.linalg.norm(displacement)) if change.centre else None,
        "data alone +- [m]": _finite(spread) if change.centre else None,
        "inertia, file [kg m^2]": None,
        "inertia, identified [kg m^2]": None,
        "lower95 [kg m^2]": None,
        "upper95 [kg m^2]": None,
        "data alone +- [kg m^2]": None,
        "beyond reason": ", ".join(moved.name for moved in change.unreasonable),
    }
    if inertia is not None:
        row |= {
            "inertia, file [kg m^2]": inertia.before,
            "inertia, identified [kg m^2]": inertia.after,
            "lower95 [kg m^2]": float(inertia.interval[0]),
            "upper95 [kg m^2]": float(inertia.interval[1]),
            "data alone +- [kg m^2]": _finite(inertia.deviation),
        }
    return row


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def validation_rows(result: FeasibleCalibration) -> list[Row]:
    """One row a role and joint, and one for all joints together."""
    rows: list[Row] = []
    names = result.plain.dataset.robot.joint_names
    for role, feasible in result.validation.items():
        plain = result.plain.validation[role]
        pairs = [
            *zip(names, plain.rms, feasible.rms, feasible.relative_rms, strict=True),
            ("all", plain.overall_rms, feasible.overall_rms, feasible.overall_relative_rms),
        ]
        for joint, before, after, relative in pairs:
            rows.append(
                {
                    "recordings": role,
                    "joint": joint,
                    "plain rms": float(before),
                    "feasible rms": float(after),
                    "price [%]": float(100 * (after / before - 1)) if before > 0 else None,
                    "feasible rms / torque rms": float(relative),
                }
            )
    return rows
