"""What a diagnosis by evidence hands on: diagnosis.json, a figure and a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from oed.diagnosis_new.diagnose import Diagnosis
from oed.report.diagnosis_plots import plot_proof
from oed.report.evidence_page import evidence_page
from oed.report.evidence_record import evidence_record
from oed.report.joint_words import joint_labels, torque_units
from oed.report.json_file import plain_value, write_json
from oed.report.page import write_page
from oed.report.provenance import Provenance
from oed.report.style import save_figure


def write_evidence(
    found: Diagnosis,
    *,
    data: str,
    joints: Sequence[str],
    notes: Sequence[str] = (),
    provenance: Provenance,
    out: Path,
) -> None:
    """Leave diagnosis.json, report.html and proof.png in a folder.

    Args:
        found: The diagnosis.
        data: Name of the data set.
        joints: Names of its joints.
        notes: What is doubtful about its numbers.
        provenance: Of the run.
        out: Folder, made if absent.
    """
    # First: what cannot be recorded leaves nothing behind.
    record = plain_value(
        evidence_record(found, data=data, joints=joints, notes=notes, provenance=provenance)
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
    saved = save_figure(figure, out / "proof", ("png",))
    page = evidence_page(
        found, data=data, joints=joints, notes=notes, proof=saved[0], provenance=provenance
    )
    write_page(out / "report.html", page)
    # Last: a folder that has the record is complete.
    write_json(out / "diagnosis.json", record)
