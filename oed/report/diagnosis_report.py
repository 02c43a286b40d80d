"""What a diagnosis hands on: diagnosis.json, a figure and a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from oed.design.export import SetPoints, write_csv
from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.report.diagnosis_page import diagnosis_page
from oed.report.diagnosis_plots import (
    ADDITIONS,
    PROOF,
    Curve,
    CurvePanel,
    plot_contributions,
    plot_proof,
)
from oed.report.diagnosis_record import FORMAT, NEXT, diagnosis_record
from oed.report.joint_words import coordinate_label, joint_labels, torque_units
from oed.report.json_file import plain_value, write_json
from oed.report.next_page import FILE, next_page
from oed.report.next_steps import Run
from oed.report.page import Picture, write_page
from oed.report.provenance import Provenance
from oed.report.style import save_figure
from oed.report.term_words import TermWords, in_words, words_of_terms
from oed.report.torque_charts import RoleTorques
from oed.robot import Robot


def write_diagnosis(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    torques: Sequence[RoleTorques],
    data: str,
    joints: Sequence[str],
    notes: Sequence[str] = (),
    run: Run,
    provenance: Provenance,
    out: Path,
) -> None:
    """Leave diagnosis.json, report.html, figures and next_experiment/ in a folder.

    Args:
        found: The diagnosis.
        following: The motion that tells apart what is open, if anything is.
        torques: Measured torque and that of both models, role by role.
        data: Name of the data set.
        joints: Names of its joints.
        notes: What is doubtful about its numbers.
        run: Where it was made, for the commands of what to do next.
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
    pictures = {"proof": _proof(found, joints, out)}
    if found.curves:
        shown = _panels(found)
        files = save_figure(plot_contributions(shown), out / "additions", ("png",))
        narrow = plot_contributions(shown, narrow=True)
        pictures["additions"] = Picture(files[0], ADDITIONS, narrow=narrow)
    if following is not None:
        write_next(following, found.before.model.robot, joints, out / NEXT, words_of_terms(found))
    page = diagnosis_page(
        found,
        following,
        torques=torques,
        data=data,
        joints=joints,
        notes=notes,
        pictures=pictures,
        run=run,
        provenance=provenance,
    )
    write_page(out / "report.html", page)
    # Last: a folder that has the record is complete.
    write_json(out / "diagnosis.json", record)


def _proof(found: Diagnosis, joints: Sequence[str], out: Path) -> Picture:
    """Errors before and after, as a file and as a picture of the page."""
    roles = {
        e.role: (
            np.column_stack([e.before, e.before_interval]),
            np.column_stack([e.after, e.after_interval]),
        )
        for e in found.errors
    }
    told = (
        roles,
        found.noise_floor,
        joint_labels(joints),
        torque_units(found.before.model.robot.joints),
    )
    files = save_figure(plot_proof(*told), out / "proof", ("png",))
    return Picture(files[0], PROOF, narrow=plot_proof(*told, narrow=True))


def write_next(
    following: NextExperiment,
    robot: Robot,
    joints: Sequence[str],
    folder: Path,
    words: Mapping[str, TermWords],
) -> None:
    """The discriminating motion as set points, its page, and what it promises."""
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(SetPoints(tuple(joints), following.motion), folder / FILE)
    write_page(folder / "report.html", next_page(following, robot, words))
    record = {
        "format": FORMAT,
        "pairs": [in_words(pair, words) for pair in following.pairs],
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
    words = words_of_terms(found)
    return [
        CurvePanel(
            f"joint {c.joint + 1}: {words[c.label].what_at(c.joint)}",
            units[c.joint],
            coordinate_label(c.coordinate, joints),
            c.is_along,
            Curve(c.centre, c.missing, c.error),
            Curve(c.centre, c.given, np.zeros_like(c.given)),
        )
        for c in found.curves
    ]
