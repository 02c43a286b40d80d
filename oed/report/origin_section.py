"""Where the figures of a page come from: settings, data, versions."""

from __future__ import annotations

from oed.estimation.calibration import Calibration
from oed.experiment.stretches import gap_notes, gap_record
from oed.report.page import Section, Table, Text
from oed.report.provenance import Provenance


def origin_section(calibration: Calibration, provenance: Provenance) -> Section:
    """How an estimate was made, and what is doubtful about its data.

    Args:
        calibration: With the settings and the data set.
        provenance: Of the run.
    """
    dataset = calibration.dataset
    return Section(
        "How it was made",
        (
            *(Text(reason) for reason in calibration.settings.reasons),
            *(Text(f"Note: {note}.") for note in dataset.notes),
            *(Text(f"Gaps: {note}.") for note in gap_notes(gap_record(dataset))),
            Text(f"Data: {dataset.source}. Licence: {dataset.licence}."),
            Table([{"package": k, "version": v} for k, v in provenance.versions.items()]),
            Text(f"Commit {provenance.commit}, {provenance.date}, {provenance.cpu}."),
        ),
    )
