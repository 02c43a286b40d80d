"""What an identification hands on: estimate.json, tables, figures and a page."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from numpy import ndarray

from oed.checkup.checkup import doubts
from oed.checkup.finding import Checkup, share
from oed.estimation.calibration import Calibration
from oed.estimation.reach import LARGEST_REACH
from oed.estimation.recursive import RecursiveEstimate
from oed.experiment.processing import ProcessedRecording
from oed.experiment.recording import HELD_OUT, Role
from oed.report.calibration_record import (
    condition,
    estimate_record,
    parameter_rows,
    validation_rows,
)
from oed.report.estimation_plots import plot_residual_spectrum, plot_residuals, plot_torques
from oed.report.joint_words import torque_label, torque_units
from oed.report.json_file import write_json
from oed.report.origin_section import origin_section
from oed.report.page import Page, Picture, Section, Table, Text, Verdict, write_page
from oed.report.parameter_plots import plot_parameter_convergence, plot_parameter_intervals
from oed.report.provenance import Provenance
from oed.report.style import save_figure
from oed.report.table import text_table, write_csv

VALIDATION_CAPTION = (
    "rms: of measured less predicted torque [N m, N at a prismatic joint]; relative_rms: the same "
    "over the rms of the measured torque."
)
LISTED = 8  # names in a line
PARAMETER_COLUMNS = ("name", "expression", "unit", "value", "std", "lower95", "upper95")
PARAMETER_PICTURES = {
    "parameters": "Estimates with 95 % intervals.",
    "convergence": "Recursive estimates against samples used, with 95 % intervals of (8), "
    "which take residuals as white.",
}
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
    """Leave estimate.json, tables, figures and report.html in a folder.

    Args:
        calibration: To write down.
        history: Of its recursive estimate.
        spectrum: Frequency and density of its residual.
        out: Folder, made if absent.
        provenance: Of the run.
        checkup: Of its data.
    """
    out.mkdir(parents=True, exist_ok=True)
    figures = draw_figures(calibration, history, spectrum)
    pictures = {
        name: save_figure(figure, out / name, ("png",))[0] for name, figure in figures.items()
    }
    write_csv(out / "parameters.csv", parameter_rows(calibration), columns=PARAMETER_COLUMNS)
    write_csv(out / "validation_errors.csv", validation_rows(calibration))
    write_page(out / "report.html", _page(calibration, checkup, pictures, provenance))
    # Last: whoever finds this file finds the rest complete.
    write_json(out / "estimate.json", estimate_record(calibration, checkup, provenance))


def draw_figures(
    calibration: Calibration, history: RecursiveEstimate, spectrum: Spectrum
) -> dict[str, Figure]:
    """Figures by file stem: torque and residual for each role, parameters, convergence."""
    names, joints = calibration.dataset.robot.joint_names, calibration.dataset.robot.joints
    torque, residual = torque_label(joints), torque_label(joints, "residual torque")
    density = "residual density [(N m)²/Hz]"
    if "N" in torque_units(joints):
        density = density.replace("]", "; N²/Hz at prismatic joints]")
    figures: dict[str, Figure] = {}
    for role, recordings in calibration.recordings.items():
        t = _joined_time(recordings)
        measured = np.concatenate([recording.tau for recording in recordings])
        result = calibration.validation[role]
        figures[f"torque_{role}"] = plot_torques(
            t, measured, measured - result.residual, names, ylabel=torque
        )
        figures[f"residual_{role}"] = plot_residuals(
            t, result.residual, names, result.rms, ylabel=residual
        )
    figures["spectrum_estimation"] = plot_residual_spectrum(
        *spectrum, names, cutoff=calibration.settings.cutoff, ylabel=density
    )
    estimate = calibration.estimate
    interval = estimate.interval(0.95)
    shown = estimate.determined
    if shown.any():
        figures["parameters"] = plot_parameter_intervals(
            [n for n, keep in zip(estimate.names, shown, strict=True) if keep],
            estimate.parameters[shown],
            interval[shown, 0],
            interval[shown, 1],
            [u for u, keep in zip(estimate.units, shown, strict=True) if keep],
        )
    # It keeps the directions that the estimate leaves out, and settles elsewhere.
    if not (estimate.reach > LARGEST_REACH).any():
        figures["convergence"] = _draw_convergence(calibration, history)
    return figures


def print_summary(calibration: Calibration, checkup: Checkup) -> None:
    """The estimate and its validation as tables on standard output."""
    say = sys.stdout.write
    say("\n" + text_table(parameter_rows(calibration), columns=PARAMETER_COLUMNS) + "\n")
    weak = calibration.estimate.unidentifiable
    if weak:
        listed = ", ".join(weak[:LISTED]) + (", ..." if len(weak) > LISTED else "")
        say(f"not identified: {len(weak)} parameters ({listed}); report.html lists all and why\n")
    say("\n" + text_table(validation_rows(calibration)) + "\n")
    figures = condition(calibration)
    say(
        f"J_k = cond Lambda = {figures['J_k']:.4g}, J_d = log10 det Lambda = "
        f"{figures['J_d_log10']:.4g}, {figures['rows']} rows\n"
    )
    for note in doubts(checkup):
        say(f"note: {note}\n")
    if calibration.base.note:
        say(f"note: {calibration.base.note}\n")


def _joined_time(recordings: tuple[ProcessedRecording, ...]) -> Float[ndarray, " samples"]:
    """Times of recordings set one after another [s]."""
    pieces: list[ndarray] = []
    start = 0.0
    for recording in recordings:
        pieces.append(recording.motion.t - recording.motion.t[0] + start)
        start = pieces[-1][-1] + 1 / recording.rate
    return np.concatenate(pieces)


def _draw_convergence(calibration: Calibration, history: RecursiveEstimate) -> Figure:
    # Undetermined at first: the figure begins where every parameter has a value.
    known = np.isfinite(history.parameters).all(axis=1)
    estimates, std = history.parameters[known], history.std[known]
    return plot_parameter_convergence(
        history.rows[known] // calibration.dataset.robot.n,
        estimates,
        np.stack([estimates - 1.96 * std, estimates + 1.96 * std], axis=2),
        calibration.estimate.names,
        calibration.estimate.units,
    )


def _page(
    calibration: Calibration,
    checkup: Checkup,
    pictures: dict[str, Path],
    provenance: Provenance,
) -> Page:
    return Page(
        title=f"Dynamic parameters of {calibration.dataset.name}",
        verdict=_verdict(calibration, checkup),
        sections=(
            _prediction_section(calibration, checkup, pictures),
            _parameter_section(calibration, pictures),
            _residual_section(pictures),
            origin_section(calibration, provenance),
        ),
    )


def _prediction_section(
    calibration: Calibration, checkup: Checkup, pictures: dict[str, Path]
) -> Section:
    captions = {
        "torque": "Measured and reconstructed torque, recordings with role",
        "residual": "Measured minus reconstructed torque, recordings with role",
    }
    by_role = [
        Picture(pictures[f"{kind}_{role}"], f"{caption} {role}.")
        for role in calibration.recordings
        for kind, caption in captions.items()
    ]
    return Section(
        "How well it predicts",
        (
            *(Text(f"Note: {note}.") for note in doubts(checkup)),
            Table(validation_rows(calibration), caption=VALIDATION_CAPTION),
            *by_role,
        ),
    )


def _parameter_section(calibration: Calibration, pictures: dict[str, Path]) -> Section:
    return Section(
        "Parameters",
        (
            Text(f"{calibration.estimate.method}. Intervals are at 95 %."),
            Table(parameter_rows(calibration), columns=PARAMETER_COLUMNS),
            *_unidentified(calibration),
            *(
                Picture(pictures[name], caption)
                for name, caption in PARAMETER_PICTURES.items()
                if name in pictures
            ),
        ),
    )


def _residual_section(pictures: dict[str, Path]) -> Section:
    return Section(
        "What is left",
        (
            Text("A flat spectrum below the cut-off is noise; a slope is a missing effect."),
            Picture(pictures["spectrum_estimation"], "Spectral density of the residual."),
        ),
    )


def _verdict(calibration: Calibration, checkup: Checkup) -> Verdict:
    held_out: list[Role] = [role for role in HELD_OUT if role in calibration.validation]
    figures = condition(calibration)
    count = int(calibration.estimate.determined.sum())
    lost = len(calibration.estimate.unidentifiable)
    if not held_out:
        return Verdict(
            "warning",
            f"{count} parameters identified, but no recording was kept for validation.",
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
        f"{count} parameters identified; residual {shares}.",
        f"{first}{lost} parameters could not be identified. cond Lambda (J_k) = "
        f"{figures['J_k']:.3g}, log10 det Lambda (J_d) = {figures['J_d_log10']:.4g} on "
        f"{figures['rows']} rows.",
    )


def _unidentified(calibration: Calibration) -> list[Table]:
    estimate = calibration.estimate
    rows = [
        {"not identified": name, "because": reason}
        for name, reason in zip(estimate.unidentifiable, estimate.reasons, strict=True)
    ]
    return [Table(rows)] if rows else []
