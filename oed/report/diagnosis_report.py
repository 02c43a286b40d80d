"""What a diagnosis hands on: diagnosis.json, a figure and a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from oed.design.export import SetPoints, write_csv
from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.report.diagnosis_page import diagnosis_page
from oed.report.diagnosis_plots import Curve, CurvePanel, plot_contributions, plot_proof
from oed.report.diagnosis_record import FORMAT, NEXT, diagnosis_record
from oed.report.joint_words import coordinate_label, joint_labels, torque_units
from oed.report.json_file import plain_value, write_json
from oed.report.page import write_page
from oed.report.provenance import Provenance
from oed.report.style import save_figure


def write_diagnosis(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    data: str,
    joints: Sequence[str],
    notes: Sequence[str] = (),
    provenance: Provenance,
    out: Path,
) -> None:
    """Leave diagnosis.json, report.html, figures and next_experiment/ in a folder.

    Args:
        found: The diagnosis.
        following: The motion that tells apart what is open, if anything is.
        data: Name of the data set.
        joints: Names of its joints.
        notes: What is doubtful about its numbers.
        provenance: Of the run.
        out: Folder, made if absent.
    """
    # First: what cannot be recorded leaves nothing behind.
    record = plain_value(
        diagnosis_record(
            found, following, data=data, joints=joints, notes=notes, provenance=provenance
        )
    )
    out.mkdir(parents=True, exist_ok=True)
    roles = {
        e.role: (
            np.column_stack([e.before, e.before_interval]),
            np.column_stack([e.after, e.after_interval]),
        )
        for e in found.errors
    }
    units = torque_units(found.before.model.robot.joints)
    figure = plot_proof(roles, found.noise_floor, joint_labels(joints), units)
    pictures = {"proof": save_figure(figure, out / "proof", ("png",))[0]}
    if found.curves:
        drawn = plot_contributions(_panels(found))
        pictures["additions"] = save_figure(drawn, out / "additions", ("png",))[0]
    if following is not None:
        write_next(following, joints, out / NEXT)
    page = diagnosis_page(
        found,
        following,
        data=data,
        joints=joints,
        notes=notes,
        pictures=pictures,
        provenance=provenance,
    )
    write_page(out / "report.html", page)
    # Last: a folder that has the record is complete.
    write_json(out / "diagnosis.json", record)


def write_next(following: NextExperiment, joints: Sequence[str], folder: Path) -> None:
    """The discriminating motion as set points, and what it promises."""
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(SetPoints(tuple(joints), following.motion), folder / "trajectory.csv")
    record = {
        "format": FORMAT,
        "pairs": list(following.pairs),
        "separation": following.separation,
        "separation_now": following.separation_now,
        "predicted_error_rate": following.error_rate,
        "predicted_error_rate_now": following.error_rate_now,
        "motions_compared": following.tried,
        "notes": list(following.notes),
    }
    write_json(folder / "design.json", record)


def _panels(found: Diagnosis) -> list[CurvePanel]:
    joints = found.before.model.robot.joints
    units = torque_units(joints)
    return [
        CurvePanel(
            f"joint {c.joint + 1}: {c.label}",
            units[c.joint],
            coordinate_label(c.coordinate, joints),
            c.is_along,
            Curve(c.centre, c.missing, c.error),
            Curve(c.centre, c.given, np.zeros_like(c.given)),
        )
        for c in found.curves
    ]
