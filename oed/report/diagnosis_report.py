"""What a diagnosis hands on: diagnosis.json, figures, the next experiment and a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oed.design.export import SetPoints, write_csv
from oed.diagnosis.diagnosis import Diagnosis
from oed.diagnosis.evidence.contributions import Contribution, ContributionMap
from oed.diagnosis.evidence.dependence import Dependence
from oed.diagnosis.rivals.discrimination import NextExperiment
from oed.diagnosis.settings import DiagnosisSettings
from oed.parallel_map import side_by_side
from oed.report.diagnosis_page import diagnosis_page
from oed.report.diagnosis_plots import (
    Curve,
    CurvePanel,
    MapPanel,
    ResidualPanel,
    plot_contributions,
    plot_dependences,
    plot_proof,
    plot_spectra,
)
from oed.report.diagnosis_record import FORMAT, NEXT, diagnosis_record
from oed.report.joint_words import coordinate_label, joint_labels, torque_units
from oed.report.json_file import plain_value, write_json
from oed.report.page import write_page
from oed.report.provenance import Provenance
from oed.report.style import save_figure
from oed.robot.robot import Joint


def write_diagnosis(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    data: str,
    joints: Sequence[str],
    notes: Sequence[str] = (),
    settings: DiagnosisSettings,
    provenance: Provenance,
    out: Path,
) -> None:
    """Leave diagnosis.json, report.html, figures and next_experiment/ in a folder.

    Args:
        found: The diagnosis.
        following: The motion that tells rivals apart, if there are any.
        data: Name of the data set.
        joints: Names of its joints.
        notes: What is doubtful about its numbers.
        settings: How it was looked for.
        provenance: Of the run.
        out: Folder, made if absent.
    """
    # First: what cannot be recorded leaves nothing behind.
    record = plain_value(
        diagnosis_record(
            found,
            following,
            data=data,
            joints=joints,
            notes=notes,
            settings=settings,
            provenance=provenance,
        )
    )
    out.mkdir(parents=True, exist_ok=True)
    figures = draw_figures(found, joints)
    files = side_by_side(lambda name: save_figure(figures[name], out / name, ("png",)), [*figures])
    pictures = {name: file for name, (file,) in zip(figures, files, strict=True)}
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
    # Last: whoever finds this file finds the rest complete.
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
        "predicted_resolution": following.resolved,
        "motions_compared": following.tried,
        "notes": list(following.notes),
    }
    write_json(folder / "design.json", record)


def draw_figures(found: Diagnosis, joints: Sequence[str]) -> dict[str, Figure]:
    """The figures by file name."""
    robot = found.before.model.robot
    labels, units = joint_labels(joints), torque_units(robot.joints)
    pairs = list(zip(found.dependences, found.dependences_after, strict=True))
    pairs.sort(key=lambda pair: -_strength(pair[0], found))
    panels = [
        ResidualPanel(
            joint=labels[before.joint],
            unit=units[before.joint],
            coordinate=coordinate_label(before.coordinate, robot.joints),
            floor=float(found.noise_floor[before.joint]),
            before=_curve(before),
            after=_curve(after),
        )
        for before, after in pairs
    ]
    roles = {
        p.role: (
            np.column_stack([p.before, p.before_interval]),
            np.column_stack([p.after, p.after_interval]),
        )
        for p in found.proof
    }
    s = found.spectrum
    figures = {
        "proof": plot_proof(roles, found.noise_floor, labels, units),
        "dependence": plot_dependences(panels),
        "spectrum": plot_spectra(
            s.frequency,
            s.before,
            s.after,
            floor=found.noise_floor,
            cutoff=found.cutoff,
            joint_names=labels,
            units=units,
        ),
    }
    if found.contributions:
        figures["additions"] = plot_contributions(
            [_addition_panel(c, robot.joints, units) for c in found.contributions]
        )
    return figures


def _addition_panel(
    shown: Contribution, joints: Sequence[Joint], units: Sequence[str]
) -> CurvePanel | MapPanel:
    joint = shown.joint if isinstance(shown, ContributionMap) else shown.given.joint
    title, unit = f"joint {joint + 1}: {shown.label}", units[joint]
    if isinstance(shown, ContributionMap):
        first, second = (coordinate_label(c, joints) for c in shown.coordinates)
        return MapPanel(title, unit, (first, second), shown.edges, shown.given)
    coordinate = coordinate_label(shown.given.coordinate, joints)
    return CurvePanel(title, unit, coordinate, _curve(shown.missing), _curve(shown.given))


def _curve(dependence: Dependence) -> Curve:
    return Curve(dependence.centre, dependence.mean, dependence.deviation)


def _strength(dependence: Dependence, found: Diagnosis) -> float:
    """How far the mean residual leaves its own uncertainty, in noise floors."""
    if len(dependence.mean) == 0:
        return 0.0
    beyond = np.maximum(np.abs(dependence.mean) - 2 * dependence.deviation, 0.0)
    return float(np.sqrt(np.mean(beyond**2)) / found.noise_floor[dependence.joint])
