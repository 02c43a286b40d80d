"""What a search for gains hands on: gains.json, the lines for dataset.toml, and a page."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.counted import counted
from oed.estimation.load.gains import Gain, Gains
from oed.experiment.dataset import DataSet
from oed.report.chart import Chart
from oed.report.json_file import write_atomically, write_json
from oed.report.page import Command, Page, Section, Table, Text, Verdict, write_page
from oed.report.parameter_charts import interval_charts
from oed.report.provenance import Provenance
from oed.report.table import Row

FORMAT = 1
MEANING = (
    "A gain is N m (N at a slide) at the joint per A of the motor, gear included: the "
    "current_to_torque of dataset.toml."
)


@dataclass(frozen=True)
class GainsReport:
    """Gains with what is told beside them.

    Attributes:
        gains: What was found.
        dataset: The first of those they are from.
        notes: On the data.
    """

    gains: Gains
    dataset: DataSet
    notes: tuple[str, ...] = ()

    @property
    def units(self) -> tuple[str, ...]:
        """(n,) of the gains."""
        if self.gains.reference is not None:
            return (f"of {self.gains.reference}",) * self.dataset.robot.n
        per = "A" if self._is_of_amperes else "stated torque"
        torques = (
            dataclasses.replace(j, effort="N m").unit("N m") for j in self.dataset.robot.joints
        )
        return tuple(f"{torque}/{per}" for torque in torques)

    @property
    def drive(self) -> str:
        """Lines for dataset.toml; empty unless every gain is told."""
        if not (self.gains.is_complete and self._is_of_amperes):
            return ""
        values = ", ".join(f"{gain.value:.5g}" for gain in self.gains.gains)
        return f"[drive]\ncurrent_to_torque = [{values}]  # N m at the joint per A, gear included\n"

    @property
    def lines(self) -> tuple[str, ...]:
        """What is said beside the table, a sentence each."""
        gains = self.gains
        refused = tuple(
            f"{gain.joint}: {gain.reason}" for gain in gains.gains if gain.value is None
        )
        ratio = (
            f"ratios to the gain of {gains.reference}: without a known mass (--mass) nothing fixes their "
            "common factor"
        )
        return (
            *((ratio,) if gains.reference is not None else self._loads),
            *refused,
            *(f"note: {note}" for note in self.notes),
        )

    @property
    def _loads(self) -> tuple[str, ...]:
        """Where each load's centre is, given or found."""
        equations, told = self.gains.equations, []
        for k, body in enumerate(self.gains.consistent.loads):
            held = equations.loaded[k].model.frame
            about = held.from_body @ body
            x, y, z = 1e3 * about[1:4] / about[0]
            how = "found" if equations.loads[k].centre is None else "given"
            told.append(
                f"load {k + 1}: {body[0]:.4g} kg, centre of mass at x {x:.1f}, y {y:.1f}, z {z:.1f} mm "
                f"of {held.name} ({how})"
            )
        return tuple(told)

    @property
    def _is_of_amperes(self) -> bool:
        return self.dataset.robot.in_amperes or self.dataset.drive.current_to_torque is not None


def gain_rows(report: GainsReport) -> list[Row]:
    """One row a joint, beside the constant that was stated."""
    stated = report.dataset.drive.current_to_torque
    share = report.gains.relative_rms
    rows = []
    for j, (gain, unit) in enumerate(zip(report.gains.gains, report.units, strict=True)):
        low, high = gain.interval or (None, None)
        before = None if stated is None or report.gains.reference else float(stated[j])
        row: dict[str, str | float | None] = {"joint": gain.joint, "unit": unit}
        row |= {"gain": gain.value, "lower95": low, "upper95": high, "known to": _accuracy(gain)}
        if before is not None:
            off = None if gain.value is None else f"{before / gain.value - 1:+.1%}"
            row |= {"stated": before, "stated is off by": off}
        rows.append({**row, "residual / current": float(share[j])})
    return rows


def _accuracy(gain: Gain) -> str | None:
    """Half the width of an interval, as a share of the gain."""
    if gain.value is None or gain.interval is None:
        return None
    return f"{(gain.interval[1] - gain.interval[0]) / 2 / gain.value:.1%}"


def write_gains(report: GainsReport, out: Path, provenance: Provenance) -> None:
    """Leave gains.json, report.html and, where all are told, drive.toml in a folder.

    Args:
        report: To write down.
        out: Folder, which exists.
        provenance: Of the run.
    """
    if report.drive:
        write_atomically(out / "drive.toml", report.drive)
    write_page(out / "report.html", _page(report, provenance))
    # Last: whoever finds this file finds the rest complete.
    write_json(out / "gains.json", gains_record(report, provenance))


def gains_record(report: GainsReport, provenance: Provenance) -> dict[str, object]:
    """The content of gains.json; its fields are documented in docs/reference/files.md."""
    gains = report.gains
    place = gains.equations.places["log_u"]
    return {
        "format": FORMAT,
        "data": report.dataset.name,
        "joints": list(report.dataset.robot.joint_names),
        "frame": gains.equations.model.frame.name,
        "reference": gains.reference,
        "gains": [
            {**dataclasses.asdict(gain), "unit": unit}
            for gain, unit in zip(gains.gains, report.units, strict=True)
        ],
        "log_gain_covariance": gains.fit.covariance[place, place],
        "loads": gains.consistent.loads,
        "solver": gains.consistent.solution.accuracy,
        "relative_rms": gains.relative_rms,
        "notes": list(report.notes),
        "configuration": provenance.configuration,
        "versions": provenance.versions,
        "commit": provenance.commit,
        "date": provenance.date,
    }


def _page(report: GainsReport, provenance: Provenance) -> Page:
    copy = (Text("For dataset.toml:"), Command(report.drive)) if report.drive else ()
    return Page(
        title=f"Drive gains of {report.dataset.robot.name}",
        subtitle=report.dataset.name,
        verdict=_verdict(report),
        sections=(
            Section(
                "Joint by joint",
                (Text(MEANING), Table(gain_rows(report)), *_charts(report), *copy),
            ),
            Section("Loads, and what is not told", tuple(Text(f"{x}.") for x in report.lines)),
            Section(
                "How it was made",
                (
                    Text(
                        "Currents of all joints are explained at once, by one arm whose parameters "
                        "the joints share, the known loads, friction and the gains; bodies can exist."
                    ),
                    Text(f"Data: {report.dataset.source}. Licence: {report.dataset.licence}."),
                    Text(f"Commit {provenance.commit}, {provenance.date}, {provenance.cpu}."),
                ),
            ),
        ),
    )


def _charts(report: GainsReport) -> list[Chart]:
    told = [j for j, gain in enumerate(report.gains.gains) if gain.value is not None]
    if not told:
        return []
    gains = [report.gains.gains[j] for j in told]
    return interval_charts(
        [gain.joint for gain in gains],
        np.array([gain.value for gain in gains]),
        np.array([gain.interval for gain in gains]),
        [report.units[j] for j in told],
        caption="Gains with 95 % intervals.",
    )


def _verdict(report: GainsReport) -> Verdict:
    gains = report.gains.gains
    told = sum(gain.value is not None for gain in gains)
    refused = ", ".join(gain.joint for gain in gains if gain.value is None)
    text = f"Not told: {refused}." if refused else ""
    if report.gains.reference is not None:
        text = f"Ratios to {report.gains.reference} only, as no mass is known. {text}"
    return Verdict(
        "bad" if not told else "good" if told == len(gains) else "warning",
        f"The gain is told for {told} of {counted(len(gains), 'joint')}.",
        text,
    )
