"""The design file `design.json`."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy import ndarray

from oed.design.criteria import condition, log10_det
from oed.design.design import Design
from oed.design.limits import KINEMATIC
from oed.robot import JointLimits

FORMAT = 1


def design_record(
    design: Design,
    *,
    versions: dict[str, str],
    d_efficiency: dict[str, object] | None = None,
    notes: tuple[str, ...] = (),
) -> dict[str, object]:
    """What `design.json` holds; infinite limits and undefined values are null.

    Args:
        design: The design.
        versions: Of the packages that made it.
        d_efficiency: {"value", "kind": "certified" or "estimated"}, where it was computed.
        notes: What was assumed, such as limits that the robot's file does not state.
    """
    problem, certificate = design.problem, design.certificate
    certified = certificate.certified_max
    return {
        "format": FORMAT,
        "robot": problem.model.robot.name,
        "joints": list(problem.model.robot.joint_names),
        "class": problem.trajectory.name,
        "coefficients": {name: value.tolist() for name, value in design.coefficients.items()},
        "horizon": design.horizon,
        "instants": len(problem.instants),
        "rows": problem.rows,
        "base_parameters": list(problem.base.names),
        "criterion": problem.criterion
        if problem.scaling is None
        else f"{problem.criterion}_scaled",
        "J_k": _number(design.J_k),
        "J_k_continuous": _number(design.J_k_continuous),
        "J_k_scaled": None if design.J_k_scaled is None else _number(design.J_k_scaled),
        "J_d_log10": _number(design.J_d),
        "J_d_log10_continuous": _number(design.J_d_continuous),
        "with_prior": _with_prior(design),
        "d_efficiency": d_efficiency,
        "certified_max": {**certified, "torque": certified.get("torque")},
        "certified_range": {
            kind: getattr(certificate, kind).tolist()
            for kind in (*KINEMATIC, "torque")
            if getattr(certificate, kind) is not None
        }
        | {"sums": certificate.sums.tolist()},
        "certified_violation": certificate.violation,
        "limits": limits_record(problem.limits),
        "optimiser": design.optimiser,
        "seed": design.seed,
        "cpu_s": design.cpu_s,
        "evaluations": design.evaluations,
        "status": str(design.status),
        "usable": design.status.is_usable,
        "asked": [dataclasses.asdict(limit) for limit in design.status.limits],
        "notes": list(notes),
        "versions": versions,
    }


def _with_prior(design: Design) -> dict[str, float | None] | None:
    """J_k and J_d of this experiment and the earlier ones together; None if there were none."""
    if design.problem.prior is None:
        return None
    total = design.problem.information(design.z, scaled=False)
    return {"J_k": _number(condition(total)), "J_d_log10": _number(log10_det(total))}


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def limits_record(limits: JointLimits) -> dict[str, object]:
    """Limits by kind, lower and upper of each joint; infinite ones are null. Sums besides."""
    kinds = {kind: _bounds(getattr(limits, kind)) for kind in (*KINEMATIC, "torque")}
    sums = [
        {"factors": list(each.factors), "position": [_number(each.lower), _number(each.upper)]}
        for each in limits.sums
    ]
    return {**kinds, "sums": sums}


def _bounds(bounds: ndarray) -> list[list[float | None]]:
    return [[_number(lower), _number(upper)] for lower, upper in bounds]
