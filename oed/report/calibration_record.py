"""What an identification found, as plain values: the content of estimate.json and its tables."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from oed.checkup.checkup import cause_record, doubts
from oed.checkup.finding import Checkup
from oed.estimation.calibration import Calibration
from oed.estimation.file_values import file_values, total_mass
from oed.experiment.recording import HELD_OUT, Role
from oed.experiment.stretches import gap_record
from oed.report.provenance import Provenance
from oed.report.table import Row

FORMAT = 1


def estimate_record(
    calibration: Calibration, checkup: Checkup, provenance: Provenance
) -> dict[str, object]:
    """The content of estimate.json; its fields are documented in docs/reference/files.md."""
    estimate, validation = calibration.estimate, calibration.validation
    recordings = calibration.recordings
    return {
        "format": FORMAT,
        "data": calibration.dataset.name,
        "joints": list(calibration.dataset.robot.joint_names),
        "samples": {
            role: sum(len(r) for r in recordings.get(role, ())) for role in _roles(recordings)
        },
        "gaps": gap_record(calibration.dataset),
        "data_notes": list(calibration.dataset.notes),
        "parameters": [
            {
                "name": row["name"],
                "expression": row["expression"],
                "unit": row["unit"],
                "value": row["value"],
                "std": row["std"],
                "interval95": [row["lower95"], row["upper95"]],
                "file": row["file"],
            }
            for row in parameter_rows(calibration)
        ],
        "total_mass": total_mass(calibration),
        "doubts": list(doubts(checkup)),
        "cause": cause_record(checkup.cause),
        "unidentifiable": list(estimate.unidentifiable),
        "unidentifiable_because": dict(zip(estimate.unidentifiable, estimate.reasons, strict=True)),
        "condition": condition(calibration),
        # Of each direction of the parameters, largest first; those beyond 1 are left at zero.
        "reach": calibration.estimate.reach,
        "rms": {role: result.rms for role, result in validation.items()},
        # Of every joint: the deviation of noise in the band, beside which rms is to be seen.
        "noise_floor": calibration.noise_floor,
        "relative_rms": {role: result.relative_rms for role, result in validation.items()},
        "overall_relative_rms": {
            role: result.overall_relative_rms for role, result in validation.items()
        },
        # All columns that predict torque, the badly excited too: their sum is determined
        # where they were excited together, their single values are not.
        "prediction": {
            "names": list(estimate.names),
            "values": estimate.parameters,
            "covariance": estimate.covariance,
        },
        "method": estimate.method,
        "settings": {
            "model": [effect.name for effect in calibration.model.effects],
            "processing": calibration.settings.record(),
            "configuration": provenance.configuration,
        },
        "base_parameters": {
            "count": len(calibration.base),
            "note": calibration.base.note,
        },
        "versions": provenance.versions,
        "commit": provenance.commit,
        "date": provenance.date,
        "seed": provenance.seed,
    }


def condition(calibration: Calibration) -> dict[str, float | int]:
    """J_k = cond Lambda and J_d = log10 det Lambda of the weighted estimation data."""
    factor = calibration.estimate.information_factor
    return {
        "J_k": float(np.linalg.cond(factor) ** 2),
        "J_d_log10": float(2 * np.log10(np.abs(np.diag(factor))).sum()),
        "rows": int(calibration.estimate.residual.size),
    }


def parameter_rows(calibration: Calibration) -> list[Row]:
    """One row for each parameter that the data determine."""
    estimate = calibration.estimate
    interval, file = estimate.interval(0.95), file_values(calibration)
    return [
        {
            "name": name,
            "expression": calibration.base.expressions[estimate.columns[k]],
            "unit": estimate.units[k],
            "value": float(estimate.parameters[k]),
            "std": float(estimate.std[k]),
            "lower95": float(interval[k, 0]),
            "upper95": float(interval[k, 1]),
            "file": float(file[k]) if np.isfinite(file[k]) else None,
            "change": float(estimate.parameters[k] - file[k]) if np.isfinite(file[k]) else None,
        }
        for k, name in enumerate(estimate.names)
        if estimate.determined[k]
    ]


def validation_rows(calibration: Calibration) -> list[Row]:
    """One row a role and joint, and one for all joints together."""
    rows: list[Row] = []
    floor = calibration.noise_floor
    for role, result in calibration.validation.items():
        for j, joint in enumerate(calibration.dataset.robot.joint_names):
            rows.append(
                {
                    "recordings": role,
                    "joint": joint,
                    "rms": float(result.rms[j]),
                    "relative_rms": float(result.relative_rms[j]),
                    "noise_floor": None if floor is None else float(floor[j]),
                }
            )
        rows.append(
            {
                "recordings": role,
                "joint": "all",
                "rms": result.overall_rms,
                "relative_rms": result.overall_relative_rms,
                "noise_floor": None,
            }
        )
    return rows


def _roles(recordings: Mapping) -> tuple[Role, ...]:
    return ("estimation", *(r for r in HELD_OUT if r in recordings))
