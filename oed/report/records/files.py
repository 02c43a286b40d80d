"""Which record each JSON file of each command is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from oed.report.records.checking import CheckRecord, RecordedMotionRecord
from oed.report.records.designing import DesignRecord, JointTrajectoryRecord
from oed.report.records.diagnosing import DiagnosisRecord, NextExperimentRecord
from oed.report.records.estimating import EstimateRecord, FeasibleRecord
from oed.report.records.loads import GainsRecord, PayloadRecord
from oed.report.records.models import (
    CalibrationRecord,
    ExportRecord,
    RandomisationRecord,
    SamplesRecord,
)
from oed.report.records.record import ProvenanceRecord, Record

# By command, as `oed.report.study_files` calls it, and name of the file. A model.json is the same
# whatever left it, and has its own: `oed.export.model_record`.
RECORDS: Mapping[str, Mapping[str, type[Record]]] = {
    "check": {"check.json": CheckRecord, "recorded_motion.json": RecordedMotionRecord},
    "identify": {"estimate.json": EstimateRecord},
    "feasible": {"estimate.json": FeasibleRecord},
    "payload": {"payload.json": PayloadRecord},
    "gains": {"gains.json": GainsRecord},
    "close_loop": {
        "diagnosis.json": DiagnosisRecord,
        "next_experiment/design.json": NextExperimentRecord,
    },
    "design": {
        "design.json": DesignRecord,
        "joint_trajectory.json": JointTrajectoryRecord,
        "provenance.json": ProvenanceRecord,
    },
    "export": {
        "export.json": ExportRecord,
        "samples.json": SamplesRecord,
        "randomisation.json": RandomisationRecord,
    },
    "calibrate": {"calibration.json": CalibrationRecord},
    "cross-check": {"provenance.json": ProvenanceRecord},
    "demo": {"provenance.json": ProvenanceRecord},
}
# Names of schemas, where those of the files would be the same.
NAMED = {
    ("feasible", "estimate.json"): "feasible_estimate.schema.json",
    ("close_loop", "next_experiment/design.json"): "next_experiment.schema.json",
}


def schema_name(command: str, file: str) -> str:
    """Of the JSON Schema of a command's file."""
    return NAMED.get((command, file), f"{file.removesuffix('.json')}.schema.json")


def schemas() -> dict[str, dict[str, Any]]:
    """JSON Schema (2020-12) of every file but model.json, by name."""
    return {
        schema_name(command, file): msgspec.json.schema(record)
        for command, files in RECORDS.items()
        for file, record in files.items()
    }
