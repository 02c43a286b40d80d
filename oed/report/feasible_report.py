"""What a feasible identification hands on: estimate.json, tables and a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from oed.checkup.checkup import cause_record, doubts_of_data
from oed.checkup.finding import Checkup
from oed.estimation.feasible.calibration import FeasibleCalibration
from oed.experiment.stretches import gap_record
from oed.report.feasible_page import feasible_page
from oed.report.feasible_rows import (
    change_rows,
    link_rows,
    parameter_rows,
    validation_rows,
)
from oed.report.json_file import write_json
from oed.report.page import write_page
from oed.report.provenance import Provenance
from oed.report.table import Row, write_csv

FORMAT = 2


def write_feasible(
    result: FeasibleCalibration,
    exports: Sequence[Row],
    out: Path,
    provenance: Provenance,
    *,
    checkup: Checkup,
) -> None:
    """Leave estimate.json, tables and report.html in a folder.

    Args:
        result: To write down.
        exports: One row a written robot file, with its round trip.
        out: Folder, made if absent.
        provenance: Of the run.
        checkup: Of its data.
    """
    out.mkdir(parents=True, exist_ok=True)
    write_csv(out / "parameters.csv", parameter_rows(result))
    write_csv(out / "links.csv", link_rows(result))
    if result.changes:
        write_csv(out / "changed_masses.csv", change_rows(result))
    write_csv(out / "validation_errors.csv", validation_rows(result))
    page = feasible_page(result, exports, provenance, checkup=checkup)
    write_page(out / "report.html", page)
    # Last: whoever finds this file finds the rest complete.
    write_json(out / "estimate.json", feasible_record(result, exports, provenance, checkup))


def feasible_record(
    result: FeasibleCalibration, exports: Sequence[Row], provenance: Provenance, checkup: Checkup
) -> dict[str, object]:
    """The content of estimate.json."""
    estimate = result.estimate
    curve = result.curve
    return {
        "format": FORMAT,
        "data": result.plain.dataset.name,
        "joints": list(result.plain.dataset.robot.joint_names),
        "gaps": gap_record(result.plain.dataset),
        "data_notes": list(result.plain.dataset.notes),
        "doubts": list(doubts_of_data(checkup)),
        "cause": cause_record(checkup.cause),
        "parameters": parameter_rows(result),
        "links": link_rows(result),
        "validation": validation_rows(result),
        "changes_from_file": change_rows(result),
        "warnings": list(result.warnings),
        "active": list(estimate.active),
        "objective": estimate.solution.objective,
        "accuracy": {
            "words": estimate.solution.accuracy,
            "asked_for": estimate.solution.tolerance,
            "reached": estimate.solution.optimality.suboptimality,
            "is_accurate": estimate.solution.is_accurate,
            "feasibility_margin": estimate.relative_margins.min(),
        },
        "solver": {
            "name": estimate.solution.solver,
            "attempts": list(estimate.solution.attempts),
            "optimality": estimate.solution.optimality,
            "second": None if result.second is None else list(result.second.attempts),
            "relative_difference": result.disagreement,
            "second_failure": result.second_failure,
        },
        "regularisation": {
            "kind": estimate.problem.regularisation.kind,
            "weight": estimate.problem.regularisation.weight,
            "reference": result.inertials.reason,
            "joint_variances": result.joint_variances,
            "curve": None
            if curve is None
            else {
                "weights": curve.weights,
                "held_out": [None if np.isnan(error) else float(error) for error in curve.mean],
                "unsolved": list(curve.unsolved),
                "least_squares": float(curve.least_squares.mean()),
            },
        },
        "mass_matrix": {
            "poses": result.settings.poses,
            "positive_definite": result.positive_definite,
            "positive_definite_plain": result.plain_positive_definite,
        },
        "plain_estimate": _plain_record(result),
        "uncertainty": result.bootstrap.method,
        "exports": list(exports),
        "versions": provenance.versions,
        "configuration": provenance.configuration,
        "commit": provenance.commit,
        "date": provenance.date,
        "seed": provenance.seed,
    }


def _plain_record(result: FeasibleCalibration) -> dict[str, object]:
    test = result.plain_feasibility
    if test is None:
        return {"has_feasible_robot": None, "failure": result.plain_feasibility_failure}
    return {
        "has_feasible_robot": test.is_feasible,
        "margin": test.margin,
        "bound": test.certificate.bound,
        "certificate_residual": test.certificate.residual,
        "blamed": list(test.blamed),
    }
