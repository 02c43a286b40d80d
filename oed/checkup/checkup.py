"""Look a data set over before anything is made of it: typed findings, each with its evidence."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from oed.checkup.cause import Cause
from oed.checkup.clipping import clipping_finding
from oed.checkup.copies import copy_finding
from oed.checkup.delay import delay_finding
from oed.checkup.finding import Checkup, Finding
from oed.checkup.fit_findings import (
    cause_finding,
    error_finding,
    impossible_finding,
    parameter_finding,
)
from oed.checkup.gravity import gravity_finding
from oed.checkup.log_findings import (
    noise_finding,
    rate_finding,
    reader_finding,
    repetition_finding,
    saturation_finding,
    standstill_finding,
)
from oed.checkup.motion_findings import coverage_finding, range_finding
from oed.checkup.search import Search, find_cause
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from oed.estimation.calibration import Calibration, calibrate
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.preparation.settings import ProcessingSettings
from oed.experiment.recording import Role


def check_dataset(dataset: DataSet, model: TorqueModel, settings: ProcessingSettings) -> Checkup:
    """All that can be said of a data set: its log, its motion, its signs and units, its estimate.

    Args:
        dataset: At least one recording for estimation.
        model: Of its robot, to be estimated.
        settings: Of the signal processing.

    Returns:
        The findings; where no estimate can be made, one of them says why.

    Raises:
        ValueError: If there is no recording for estimation, or one is too short.
    """
    recordings = process_all(dataset, settings)
    search = find_cause(dataset, model, recordings)
    try:
        fitted = _of_estimate(calibrate(dataset, model, settings), search)
    except OedError as error:
        fitted = (Finding("prediction", "red", f"no estimate can be made: {error}"),)
    fitted += _of_trials(dataset, model, recordings, search)
    return _assembled(dataset, settings, search, fitted)


def check_calibration(calibration: Calibration) -> Checkup:
    """The same of a data set of which an estimate was made."""
    dataset, settings = calibration.dataset, calibration.settings
    search = find_cause(dataset, calibration.model, calibration.recordings)
    fitted = _of_estimate(calibration, search)
    fitted += _of_trials(dataset, calibration.model, calibration.recordings, search)
    return _assembled(dataset, settings, search, fitted)


# Said of the log when it is read, and recorded apart from what an estimate shows.
OF_READING = ("rate and gaps", "values")


# Said of plain least squares; an estimate with demands and a prior has none of these troubles.
OF_PLAIN_ESTIMATE = ("prediction", "parameters", "signs of parameters")


def doubts(checkup: Checkup) -> tuple[str, ...]:
    """The notes of a checkup that reading the data set did not already give."""
    return _without(checkup, OF_READING)


def doubts_of_data(checkup: Checkup) -> tuple[str, ...]:
    """The notes that concern any estimate from these data, however it is made."""
    return _without(checkup, OF_READING + OF_PLAIN_ESTIMATE)


def _without(checkup: Checkup, topics: tuple[str, ...]) -> tuple[str, ...]:
    kept = tuple(f for f in checkup.findings if f.topic not in topics)
    return Checkup(checkup.name, kept, checkup.cause).notes


Recordings = Mapping[Role, tuple[ProcessedRecording, ...]]


def _of_trials(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Recordings,
    search: Search,
) -> tuple[Finding, ...]:
    """Time of the torque; a log with a named fault is mended before this is asked."""
    if search.cause is not None:
        return ()
    return (delay_finding(dataset, model, recordings),)


def _of_estimate(calibration: Calibration, search: Search) -> tuple[Finding, ...]:
    return (
        error_finding(calibration, search),
        parameter_finding(calibration),
        impossible_finding(calibration),
    )


def _assembled(
    dataset: DataSet,
    settings: ProcessingSettings,
    search: Search,
    fitted: tuple[Finding, ...],
) -> Checkup:
    findings = (
        cause_finding(dataset, search),
        gravity_finding(dataset),
        *fitted,
        coverage_finding(dataset),
        range_finding(dataset),
        standstill_finding(dataset),
        rate_finding(dataset, settings),
        noise_finding(dataset, settings),
        repetition_finding(dataset),
        saturation_finding(dataset),
        clipping_finding(dataset),
        copy_finding(dataset),
        reader_finding(dataset),
    )
    return Checkup(dataset.name, findings, search.cause)


def cause_record(cause: Cause | None) -> Mapping[str, str] | None:
    """A cause in a JSON record."""
    return None if cause is None else dataclasses.asdict(cause)


def checkup_record(checkup: Checkup) -> Mapping[str, object]:
    """The content of check.json."""
    return {
        "format": 1,
        "data": checkup.name,
        "level": checkup.level,
        "cause": cause_record(checkup.cause),
        "findings": [
            {
                "topic": f.topic,
                "level": f.level,
                "text": f.text,
                "remedy": f.remedy,
                "evidence": [dict(row) for row in f.rows],
            }
            for f in checkup.findings
        ],
        "notes": list(checkup.notes),
    }
