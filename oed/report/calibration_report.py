"""What an identification hands on: estimate.json, tables and a page."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.checkup.checkup import doubts
from oed.checkup.finding import Checkup, share
from oed.counted import counted
from oed.estimation.calibration import Calibration
from oed.estimation.file_values import file_values, total_mass
from oed.estimation.reach import LARGEST_REACH
from oed.estimation.recursive import RecursiveEstimate
from oed.estimation.validation import Validation
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import HELD_OUT, Role
from oed.report.calibration_record import (
    condition,
    estimate_record,
    parameter_rows,
    validation_rows,
)
from oed.report.chart import THINNED, points_for
from oed.report.estimation_charts import spectrum_chart
from oed.report.joint_words import torque_label, torque_units
from oed.report.json_file import write_json
from oed.report.origin_section import origin_section
from oed.report.page import Page, Section, Table, Text, Verdict, write_page
from oed.report.parameter_charts import convergence_chart, interval_charts
from oed.report.provenance import Provenance
from oed.report.table import text_table, write_csv
from oed.report.torque_charts import RoleTorques, Rows, torque_charts
from oed.robot.placeholder_inertia import placeholder_reasons

VALIDATION_CAPTION = (
    "rms: of measured less predicted {}, a row counted less where the direction of motion is uncertain; "
    "relative_rms: the same over the rms of what was measured; noise_floor: the deviation of noise in the "
    "band, which no model explains."
)
LISTED = 8  # names in a line
PARAMETER_COLUMNS = (
    "name",
    "expression",
    "unit",
    "value",
    "std",
    "lower95",
    "upper95",
    "file",
    "change",
)
# What is compared stands first, where a narrow screen shows it.
SHOWN_COLUMNS = (
    "name",
    "unit",
    "file",
    "value",
    "change",
    "lower95",
    "upper95",
    "std",
    "expression",
)
FROM_FILE = (
    "file: the same combination of the inertials in the robot's file, empty where no such file says it, as of "
    "friction; change: the value less that."
)
CONVERGENCE = (
    "Recursive estimates against samples used, as distances from their final values in standard "
    "deviations of (8), which take residuals as white."
)
Spectrum = tuple[Float[ndarray, " frequencies"], Float[ndarray, "frequencies joints"]]


def write_calibration(
    calibration: Calibration,
    history: RecursiveEstimate,
    spectrum: Spectrum,
    out: Path,
    provenance: Provenance,
    *,
    checkup: Checkup,
) -> None:
    """Leave estimate.json, tables and report.html in a folder.

    Args:
        calibration: To write down.
        history: Of its recursive estimate.
        spectrum: Frequency and density of its residual.
        out: Folder, made if absent.
        provenance: Of the run.
        checkup: Of its data.
    """
    out.mkdir(parents=True, exist_ok=True)
    write_csv(out / "parameters.csv", parameter_rows(calibration), columns=PARAMETER_COLUMNS)
    write_csv(out / "validation_errors.csv", validation_rows(calibration))
    write_page(out / "report.html", _page(calibration, history, spectrum, checkup, provenance))
    # Last: whoever finds this file finds the rest complete.
    write_json(out / "estimate.json", estimate_record(calibration, checkup, provenance))


def print_summary(calibration: Calibration, checkup: Checkup) -> None:
    """The estimate and its validation as tables on standard output."""
    say = sys.stdout.write
    say("\n" + text_table(parameter_rows(calibration), columns=PARAMETER_COLUMNS) + "\n")
    weak = calibration.estimate.unidentifiable
    if weak:
        listed = ", ".join(weak[:LISTED]) + (", ..." if len(weak) > LISTED else "")
        say(
            f"not identified: {counted(len(weak), 'parameter')} ({listed}); report.html lists all and why\n"
        )
    say("\n" + text_table(validation_rows(calibration)) + "\n")
    figures = condition(calibration)
    say(
        f"J_k = cond Lambda = {figures['J_k']:.4g}, J_d = log10 det Lambda = "
        f"{figures['J_d_log10']:.4g}, {counted(int(figures['rows']), 'row')}\n"
    )
    for note in doubts(checkup):
        say(f"note: {note}\n")
    if calibration.base.note:
        say(f"note: {calibration.base.note}\n")


def _page(
    calibration: Calibration,
    history: RecursiveEstimate,
    spectrum: Spectrum,
    checkup: Checkup,
    provenance: Provenance,
) -> Page:
    return Page(
        title=f"Dynamic parameters of {calibration.dataset.name}",
        verdict=_verdict(calibration, checkup),
        sections=(
            _prediction_section(calibration, checkup),
            _parameter_section(calibration, history),
            _residual_section(calibration, spectrum),
            origin_section(calibration, provenance),
        ),
    )


def _prediction_section(calibration: Calibration, checkup: Checkup) -> Section:
    robot = calibration.dataset.robot
    roles = [
        RoleTorques(
            role,
            Rows.end_to_end(_rows(calibration.validation[role], recordings)),
            {"predicted": calibration.validation[role].rms},
            calibration.validation[role].rms,
        )
        for role, recordings in calibration.recordings.items()
    ]
    return Section(
        "How well it predicts",
        (
            *(Text(f"Note: {note}.") for note in doubts(checkup)),
            Table(
                validation_rows(calibration),
                caption=VALIDATION_CAPTION.format(torque_label(robot.joints)),
            ),
            *torque_charts(robot, roles, band="± rms"),
            Text(THINNED),
        ),
    )


def _rows(found: Validation, recordings: Sequence[ProcessedRecording]) -> list[Rows]:
    """Each recording with its part of the residual."""
    ends = np.cumsum([len(recording) for recording in recordings])[:-1]
    return [
        Rows(recording.motion.t, recording.tau, {"predicted": recording.tau - residual})
        for recording, residual in zip(recordings, np.split(found.residual, ends), strict=True)
    ]


def _parameter_section(calibration: Calibration, history: RecursiveEstimate) -> Section:
    estimate = calibration.estimate
    shown = np.flatnonzero(estimate.determined)
    charts = interval_charts(
        [estimate.names[k] for k in shown],
        estimate.parameters[shown],
        estimate.interval(0.95)[shown],
        [estimate.units[k] for k in shown],
        caption="Estimates with 95 % intervals; diamonds are the robot file's values.",
        file=file_values(calibration)[shown],
    )
    # It keeps the directions that the estimate leaves out, and settles elsewhere.
    if not (estimate.reach > LARGEST_REACH).any():
        # Undetermined at first: the figure begins where every parameter has a value.
        known = np.isfinite(history.parameters).all(axis=1)
        charts.append(
            convergence_chart(
                history.rows[known] // calibration.dataset.robot.n,
                history.parameters[known],
                history.std[known],
                estimate.names,
                estimate.units,
                caption=CONVERGENCE,
            )
        )
    return Section(
        "Parameters",
        (
            Text(f"{estimate.method}. Intervals are at 95 %."),
            Table(parameter_rows(calibration), FROM_FILE, SHOWN_COLUMNS),
            *_of_file(calibration),
            *_unidentified(calibration),
            *charts,
        ),
    )


def _of_file(calibration: Calibration) -> list[Text]:
    """The total mass, and what the file's inertials are worth."""
    mass = total_mass(calibration)
    doubt = [
        Text(f"The file's inertials are placeholders, and no values of the arm's: {reason}.")
        for reason in placeholder_reasons(calibration.model.robot)
    ]
    said = f"Total mass of what moves: {mass.file:.4g} kg in the robot's file"
    if mass.value is not None and mass.interval is not None:
        low, high = mass.interval
        return [
            Text(
                f"{said}, {mass.value:.4g} kg as identified (95 %: {low:.4g} to {high:.4g} kg), "
                f"{mass.value - mass.file:+.4g} kg."
            ),
            *doubt,
        ]
    why = (
        "these recordings do not determine it"
        if mass.is_in_torque
        else "the torques of this arm do not depend on it, but on the combinations above alone"
    )
    rest = "`oed feasible` gives one of bodies that exist, with how far it is known"
    return [Text(f"{said}. None is identified: {why}; {rest}."), *doubt]


def _residual_section(calibration: Calibration, spectrum: Spectrum) -> Section:
    robot = calibration.dataset.robot
    chart = spectrum_chart(
        *spectrum, robot.joint_names, torque_units(robot.joints),
        cutoff=calibration.settings.cutoff, points=points_for(robot.n),
        caption="Spectral density of the residual.",
    )  # fmt: skip
    return Section(
        "What is left",
        (
            Text("A flat spectrum below the cut-off is noise; a slope is a missing effect."),
            chart,
        ),
    )


def _verdict(calibration: Calibration, checkup: Checkup) -> Verdict:
    held_out: list[Role] = [role for role in HELD_OUT if role in calibration.validation]
    figures = condition(calibration)
    found = counted(int(calibration.estimate.determined.sum()), "parameter")
    lost = len(calibration.estimate.unidentifiable)
    if not held_out:
        return Verdict(
            "warning",
            f"{found} identified, but no recording was kept for validation.",
            "Add a recording with role validation before trusting these figures.",
        )
    shares = ", ".join(
        f"{share(calibration.validation[role].overall_relative_rms)} on {role}" for role in held_out
    )
    notes = doubts(checkup)
    first = f"{notes[0][0].upper()}{notes[0][1:]}. " if notes and checkup.level == "red" else ""
    level = "bad" if checkup.level == "red" else "warning" if lost or notes else "good"
    return Verdict(
        level,
        f"{found} identified; residual {shares}.",
        f"{first}{counted(lost, 'parameter')} could not be identified. cond Lambda (J_k) = "
        f"{figures['J_k']:.3g}, log10 det Lambda (J_d) = {figures['J_d_log10']:.4g} on "
        f"{counted(int(figures['rows']), 'row')}.",
    )


def _unidentified(calibration: Calibration) -> list[Table]:
    estimate = calibration.estimate
    rows = [
        {"not identified": name, "because": reason}
        for name, reason in zip(estimate.unidentifiable, estimate.reasons, strict=True)
    ]
    return [Table(rows)] if rows else []
