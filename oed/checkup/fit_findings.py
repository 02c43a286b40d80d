"""What an estimate shows of its data: what they determine, what is impossible, what is predicted badly."""

from __future__ import annotations

import re

import numpy as np

from oed.checkup.cause import USELESS
from oed.checkup.finding import EvidenceRow, Finding, multiple, share
from oed.checkup.search import Search
from oed.counted import counted
from oed.estimation.calibration import Calibration
from oed.estimation.reach import LARGEST_REACH
from oed.experiment.dataset import DataSet
from oed.experiment.recording import HELD_OUT, Role

# What is negative for no joint and no link; a sum with other parameters may be.
NEVER_NEGATIVE = {
    "Fc": "Coulomb friction",
    "Fv": "viscous friction",
    "Ia": "rotor inertia",
    "m": "mass",
}
LISTED = 4  # names in a line; the table has all


def cause_finding(dataset: DataSet, search: Search) -> Finding:
    """Units, signs and order, decided by tests."""
    projection = search.projection
    rows: tuple[EvidenceRow, ...] = tuple(
        {
            "joint": name,
            f"measured rms [{dataset.torque_unit}]": float(projection.measured[j]),
            "by the file's inertials": float(projection.needed[j]),
            "ratio": float(projection.slope[j]),
            "correlation": float(projection.correlation[j]),
            "tells": bool(projection.telling[j]),
            "scale told by the fit": j not in search.untold,
        }
        for j, name in enumerate(dataset.robot.joint_names)
    )
    if search.cause is not None:
        cause = search.cause
        return Finding(
            "units and signs", "red", f"{cause.text} ({cause.evidence})", cause.remedy, rows
        )
    telling = int(projection.telling.sum())
    if (search.as_logged.relative > USELESS).any():
        text = (
            "no reversed sign, exchange, direction of gravity, unit or offset alone repairs the fit"
        )
    else:
        text = "signs, order, units and gravity fit together: the model explains the torque of every joint"
    blind = ", ".join(dataset.robot.joint_names[j] for j in search.untold)
    if blind:
        blind = f"; ten times or a tenth of the torque of {blind} would fit nearly as well: check its unit and gear"
    return Finding(
        "units and signs",
        "green",
        f"{text}; the torque of {telling} of {counted(len(rows), 'joint')} follows the robot file's own inertials{blind}",
        "",
        rows,
    )


def parameter_finding(calibration: Calibration) -> Finding:
    """How many parameters the data determine, and which not."""
    estimate = calibration.estimate
    lost = int(np.sum(estimate.reach > LARGEST_REACH))
    weak = estimate.unidentifiable
    rows: tuple[EvidenceRow, ...] = tuple(
        {"not identified": name, "because": reason}
        for name, reason in zip(weak, estimate.reasons, strict=True)
    )
    condition = float(np.linalg.cond(estimate.information_factor) ** 2)
    count = int(estimate.determined.sum())
    text = (
        f"{count} of {len(calibration.base)} base parameters are determined, J_k = {condition:.3g}"
    )
    if lost:
        text += (
            f"; along {lost} of {counted(len(estimate.reach), 'direction')} the recordings for estimation excite "
            f"too little: an error of the size of their residual, hidden there, would change what is "
            f"predicted by up to {estimate.reach.max():.3g} times the torque; these are left at zero"
        )
        return Finding(
            "parameters", "red", text, "record the motion that the checkup proposes", rows
        )
    if weak:
        names = ", ".join(weak[:LISTED]) + (", ..." if len(weak) > LISTED else "")
        text += f"; {len(weak)} are not ({names})"
    level = "amber" if len(weak) > count else "green"
    remedy = "record the motion that the checkup proposes" if level == "amber" else ""
    return Finding("parameters", level, text, remedy, rows)


def impossible_finding(calibration: Calibration) -> Finding:
    """Parameters that are negative beyond their intervals though they cannot be."""
    # Only those that stand alone: regrouped with others, a negative sum is no fault.
    estimate, rows = calibration.estimate, []
    interval = estimate.interval(0.95)
    for k, name in enumerate(estimate.names):
        symbol = re.sub(r"_\d+$", "", name)
        is_alone = calibration.base.expressions[estimate.columns[k]] == name
        if estimate.determined[k] and is_alone and symbol in NEVER_NEGATIVE and interval[k, 1] < 0:
            rows.append(
                {
                    "parameter": name,
                    "value": float(estimate.parameters[k]),
                    "upper95": float(interval[k, 1]),
                    "unit": estimate.units[k],
                    "is a": NEVER_NEGATIVE[symbol],
                }
            )
    if not rows:
        return Finding(
            "signs of parameters", "green", "no friction, mass or rotor inertia is negative"
        )
    told = ", ".join(
        f"{row['parameter']} = {row['value']:.3g} {row['unit']}" for row in rows[:LISTED]
    )
    more = f" and {len(rows) - LISTED} more" if len(rows) > LISTED else ""
    return Finding(
        "signs of parameters",
        "amber",
        f"negative, which they cannot be: {told}{more}",
        "the feasible estimate keeps to what is possible, a diagnosis (oed diagnose) looks for what the model lacks",
        tuple(rows),
    )


def error_finding(calibration: Calibration, search: Search) -> Finding:
    """How well the estimate predicts, judged on what was held out where there is any."""
    held: list[Role] = [role for role in HELD_OUT if role in calibration.validation]
    role: Role = held[0] if held else "estimation"
    result = calibration.validation[role]
    names = calibration.dataset.robot.joint_names
    rows: tuple[EvidenceRow, ...] = tuple(
        {
            "joint": name,
            **{
                f"{r} [%]": 100 * float(v.relative_rms[j])
                for r, v in calibration.validation.items()
            },
        }
        for j, name in enumerate(names)
    )
    overall = f"the residual on {role} is {share(result.overall_relative_rms)}"
    bad = np.flatnonzero(result.relative_rms > USELESS)
    if not len(bad):
        return Finding("prediction", "green", overall, "", rows)
    told = ", ".join(f"{names[j]} {multiple(result.relative_rms[j])}" for j in bad)
    level = "red" if result.overall_relative_rms > USELESS else "amber"
    return Finding("prediction", level, f"{overall}; {told}", _known(calibration, search), rows)


def _known(calibration: Calibration, search: Search) -> str:
    """What to do about a bad prediction: what is known of it, and never a guess."""
    if search.cause is not None:
        return "mend the cause named under units and signs first"
    if (calibration.estimate.reach > LARGEST_REACH).any():
        return "the motion for estimation does not determine it: record the motion that the checkup proposes; until then the feasible estimate says what can be said"
    return "no test names a cause: a diagnosis (oed diagnose) looks for what the model lacks"
