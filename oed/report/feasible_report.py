"""What a feasible identification hands on: estimate.json, tables, figures and a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.checkup.checkup import cause_record, doubts_of_data
from oed.checkup.finding import Checkup
from oed.estimation.feasible.calibration import FeasibleCalibration
from oed.experiment.recording import HELD_OUT, Role
from oed.experiment.stretches import gap_record
from oed.report.feasibility_plots import (
    plot_link_margins,
    plot_residual_comparison,
    plot_weight_curve,
)
from oed.report.feasible_page import feasible_page
from oed.report.feasible_rows import (
    MOSTLY_DATA,
    change_rows,
    link_rows,
    parameter_rows,
    validation_rows,
)
from oed.report.joint_words import torque_label
from oed.report.json_file import write_json
from oed.report.page import write_page
from oed.report.parameter_plots import plot_parameter_intervals
from oed.report.provenance import Provenance
from oed.report.style import save_figure
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
    """Leave estimate.json, tables, figures and report.html in a folder.

    Args:
        result: To write down.
        exports: One row a written robot file, with its round trip.
        out: Folder, made if absent.
        provenance: Of the run.
        checkup: Of its data.
    """
    out.mkdir(parents=True, exist_ok=True)
    pictures = {
        name: save_figure(figure, out / name, ("png",))[0]
        for name, figure in draw_figures(result).items()
    }
    write_csv(out / "parameters.csv", parameter_rows(result))
    write_csv(out / "links.csv", link_rows(result))
    if result.changes:
        write_csv(out / "changed_masses.csv", change_rows(result))
    write_csv(out / "validation_errors.csv", validation_rows(result))
    write_page(
        out / "report.html", feasible_page(result, exports, pictures, provenance, checkup=checkup)
    )
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


def draw_figures(result: FeasibleCalibration) -> dict[str, Figure]:
    """Figures by file stem."""
    estimate = result.estimate
    links = [joint.link for joint in estimate.robot.joints]
    figures = {
        "margins": plot_link_margins(links, estimate.relative_margins, estimate.problem.margin)
    }
    if result.curve is not None:
        curve = result.curve
        figures["weight"] = plot_weight_curve(
            curve.weights,
            curve.held_out,
            curve.fitted,
            best=curve.best,
            chosen=curve.chosen,
            least_squares=float(curve.least_squares.mean()),
        )
    held_out: list[Role] = [role for role in HELD_OUT if role in result.validation]
    names = result.plain.dataset.robot.joint_names
    for role in held_out:
        plain, feasible = result.plain.validation[role], result.validation[role]
        figures[f"residual_{role}"] = plot_residual_comparison(
            names,
            plain.rms,
            feasible.rms,
            ylabel=torque_label(estimate.robot.joints, f"rms residual torque, {role}"),
        )
    measured = estimate.from_data > MOSTLY_DATA
    if measured.any():
        interval = result.bootstrap.interval()
        figures["parameters"] = plot_parameter_intervals(
            [n for n, keep in zip(estimate.names, measured, strict=True) if keep],
            estimate.parameters[measured],
            interval[measured, 0],
            interval[measured, 1],
            [u for u, keep in zip(estimate.units, measured, strict=True) if keep],
        )
    return figures
