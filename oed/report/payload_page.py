"""What a weighing hands on: payload.json and a page."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from oed.report.json_file import write_json
from oed.report.page import Page, Section, Table, Text, Verdict, write_page
from oed.report.payload_charts import load_chart, load_on_arm_chart
from oed.report.payload_rows import (
    PayloadReport,
    friction_lines,
    interval_words,
    load_rows,
    residual_rows,
)
from oed.report.provenance import Provenance

FORMAT = 1
FILES = {
    "load.urdf": "a link of URDF: join it to the frame by a fixed joint without offset",
    "load.sdf": "the same of SDF",
    "load.xml": "the same of MJCF",
    "load_message.yaml": "geometry_msgs/msg/InertiaStamped of ROS 2",
    "load.script": "set_target_payload of URScript (Universal Robots), about the tool flange",
}
TYPED = (
    "As a teach pendant asks for it: kg, mm in the axes of the frame, and kg m² about the centre of "
    "mass (entries of the matrix: products of inertia with the sign of URDF). Where the data hardly "
    "tell, the body is drawn towards a solid ball of water's density with this mass."
)
RESIDUAL = (
    "Root mean square of measured less modelled torque over that of the measured torque, in the "
    "recordings with the load: of the arm alone as it was known before, and with its load."
)


def write_payload(report: PayloadReport, out: Path, provenance: Provenance) -> None:
    """Leave payload.json and report.html in a folder.

    Args:
        report: To write down.
        out: Folder, which exists.
        provenance: Of the run.
    """
    write_page(out / "report.html", _page(report, provenance))
    # Last: whoever finds this file finds the rest complete.
    write_json(out / "payload.json", payload_record(report, provenance))


def payload_record(report: PayloadReport, provenance: Provenance) -> dict[str, object]:
    """The content of payload.json; its fields are documented in docs/reference/files.md."""
    payload, friction = report.payload, report.payload.friction
    return {
        "format": FORMAT,
        "data": report.dataset.name,
        "frame": payload.frame.name,
        "route": payload.arm.route,
        "arm": payload.arm.words,
        "mass": payload.mass,
        "centre_of_mass": payload.centre,
        "quantities": [dataclasses.asdict(quantity) for quantity in payload.quantities],
        "parameters": payload.parameters,
        "least_squares": {
            "parameters": payload.linear.parameters,
            "covariance": payload.linear.covariance,
        },
        "pseudo_inertia_margin": payload.margin,
        "solver": payload.solution.accuracy,
        "load_friction": None
        if friction is None
        else {
            "joints": list(report.dataset.robot.joint_names),
            "mu": friction.mu,
            "interval95": friction.interval,
            "mass_without": friction.mass_without,
            "interval95_without": friction.interval_without,
        },
        "not_told": [dataclasses.asdict(each) for each in report.open_quantities],
        "relative_rms": payload.relative_rms,
        "notes": list(report.notes),
        "files": list(report.files),
        "processing": report.settings.record(),
        "configuration": provenance.configuration,
        "versions": provenance.versions,
        "commit": provenance.commit,
        "date": provenance.date,
    }


def _page(report: PayloadReport, provenance: Provenance) -> Page:
    payload, dataset = report.payload, report.dataset
    told = [{"not told": each.what, "what would": each.remedy} for each in report.open_quantities]
    return Page(
        title=f"Load of {dataset.robot.name} at {payload.frame.name}",
        subtitle=dataset.name,
        verdict=_verdict(report),
        sections=(
            Section("What to type", (Table(load_rows(payload)), Text(TYPED))),
            Section("Where it is", (load_on_arm_chart(payload), load_chart(payload))),
            Section(
                "What it explains",
                (
                    Table(residual_rows(report), caption=RESIDUAL),
                    *(
                        Text(f"{_capital(x)}.")
                        for x in friction_lines(payload, dataset.robot.joint_names)
                    ),
                ),
            ),
            Section(
                "What the data leave open",
                (Table(told),) if told else (Text("Nothing: every row is told by the data."),),
            ),
            Section("Files", (Table([{"file": f, "what it is": FILES[f]} for f in report.files]),)),
            Section(
                "How it was made",
                (
                    Text(f"The arm is taken from {payload.arm.words}."),
                    *(Text(f"Note: {note}.") for note in report.notes),
                    *(Text(reason) for reason in report.settings.reasons),
                    Text(f"Data: {dataset.source}. Licence: {dataset.licence}."),
                    Text(f"Commit {provenance.commit}, {provenance.date}, {provenance.cpu}."),
                ),
            ),
        ),
    )


def _verdict(report: PayloadReport) -> Verdict:
    payload = report.payload
    interval = payload["mass"].interval
    x, y, z = 1e3 * payload.centre
    if not payload.is_felt:
        return Verdict(
            "bad",
            f"No load is told from nothing: {payload.mass:.3g} kg "
            f"({interval_words(interval, 'kg')}).",
            f"The arm is taken from {payload.arm.words}.",
        )
    weak = len(report.open_quantities)
    return Verdict(
        "warning" if weak or payload.arm.route == "robot file" else "good",
        f"{payload.mass:.4g} kg ({interval_words(interval, 'kg')}) at x {x:.1f}, y {y:.1f}, z {z:.1f} mm "
        f"of {payload.frame.name}.",
        f"The arm is taken from {payload.arm.words}. "
        + (f"{weak} of ten numbers are not told by the data." if weak else ""),
    )


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
