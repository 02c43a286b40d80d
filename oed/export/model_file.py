"""model.json: a model written down whole, and read again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy import ndarray

from oed.dynamics.effects import Effect, MeasurementEffect, with_columns
from oed.dynamics.effects import catalogue as _catalogue  # noqa: F401  and these
from oed.dynamics.effects import smooth_term as _smooth_term  # noqa: F401  a file may hold one
from oed.dynamics.torque_model import TorqueModel
from oed.export.effect_check import check_effects
from oed.export.effect_form import FormReader, FormWriter
from oed.export.file_numbers import check_numbers
from oed.export.model import Model, Origin, Ranges, ShapeEstimate
from oed.export.model_record import (
    FORMAT,
    VERSION,
    CovarianceRecord,
    EffectRecord,
    MeasurementRecord,
    ModelFileError,
    ModelRecord,
    ParameterRecord,
    RangesRecord,
    ReferenceRecord,
    ShapeRecord,
)
from oed.export.robot_record import bounds_of, pairs_of, robot_of, robot_record
from oed.input_file import UnreadableFile, read_json
from oed.report.json_file import write_atomically
from oed.report.records.models import OriginRecord

NAME = "model.json"
ROUNDING = 1e-6  # of correlations that went through a solver and a file
RANGES = ("q", "dq", "ddq", "tau")


def write_model(model: Model, path: str | Path, *, home: Path | None = None) -> Path:
    """Write a model, whole or not at all.

    Args:
        model: To write.
        path: Of the new file.
        home: Folder from which the robot's meshes are to be found, where the file is moved there
            afterwards; the file's own if None.

    Returns:
        The path.
    """
    path = Path(path)
    record = model_record(model, (home or path.parent).resolve())
    text = msgspec.json.format(msgspec.json.encode(record), indent=1).decode()
    write_atomically(path, text + "\n")
    return path


def model_file_at(path: Path) -> Path:
    """Where a model is: the file itself, or `model.json` of the folder that holds it."""
    return path / NAME if path.is_dir() else path


def load_model(path: str | Path) -> Model:
    """Read a model that an identification, a diagnosis or a feasible estimate left.

    Args:
        path: A model.json.

    Returns:
        The model with its numbers, in SI units.

    Raises:
        ModelFileError: In one line, if there is none, or it is damaged, of another program or of
            a version that this one cannot read.
    """
    path = Path(path)
    try:
        plain = read_json(path)
    except FileNotFoundError as error:
        raise ModelFileError(f"{path}: no such file; give a model.json") from error
    except UnreadableFile as error:
        raise ModelFileError(str(error)) from error
    try:
        return model_of(_record(plain), path.parent)
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}") from error
    except RecursionError as error:
        raise ModelFileError(f"{path}: is damaged: it is nested too deeply") from error


def _record(plain: object) -> ModelRecord:
    if not isinstance(plain, dict) or plain.get("format") != FORMAT:
        raise ModelFileError(
            "is no model.json: oed identify, diagnose and feasible each leave one beside their page"
        )
    if plain.get("version") != VERSION:
        raise ModelFileError(
            f"has version {plain.get('version')!r} of the format, this program reads {VERSION}: "
            "make it again with this program, or read it with the one that made it"
        )
    for key, value in plain.items():
        if key != "origin":
            check_numbers(value, key)
    try:
        return msgspec.convert(plain, ModelRecord)
    except msgspec.ValidationError as error:
        raise ModelFileError(f"is damaged: {error}") from error


def model_record(model: Model, home: Path) -> ModelRecord:
    """What the file says.

    Args:
        model: To write.
        home: Folder of the file.
    """
    whole, writer = model.torque_model, FormWriter(model.robot)
    rows = _parameter_records(model)
    shapes = model.shapes or ((),) * (len(whole.effects) + len(whole.measurement))
    effects = [
        EffectRecord(
            name=effect.name,
            form=writer.form(effect),
            parameters=rows[place],
            shapes=_shape_records(own),
        )
        for (effect, place), own in zip(with_columns(whole.effects), shapes, strict=False)
    ]
    measurement = [
        MeasurementRecord(name=m.name, form=writer.form(m), shapes=_shape_records(own))
        for m, own in zip(whole.measurement, shapes[len(effects) :], strict=True)
    ]
    return ModelRecord(
        robot=robot_record(model.robot, home),
        gravity=model.robot.gravity.tolist(),
        effects=effects,
        measurement=measurement,
        references=[msgspec.convert(x, ReferenceRecord) for x in writer.references],
        covariance=_covariance_record(model),
        is_feasible=model.is_feasible,
        validity=None
        if model.validity is None
        else RangesRecord(**{x: pairs_of(getattr(model.validity, x)) for x in RANGES}),
        origin=msgspec.convert(model.origin, OriginRecord, from_attributes=True),
    )


def model_of(record: ModelRecord, folder: Path) -> Model:
    """The model that a file describes.

    Args:
        record: What it says.
        folder: Of the file.

    Raises:
        ModelFileError: If its parts contradict each other.
    """
    robot = robot_of(record, folder)
    reader = FormReader(robot, [msgspec.to_builtins(x) for x in record.references])
    effects = tuple(
        reader.effect(e.form, Effect, f"effects[{k}]") for k, e in enumerate(record.effects)
    )
    measurement = tuple(
        reader.effect(m.form, MeasurementEffect, f"measurement[{k}]")
        for k, m in enumerate(record.measurement)
    )
    torque_model = TorqueModel(robot, effects, measurement)
    check_effects(torque_model)
    _check_parameters(record, effects)
    rows = [row for effect in record.effects for row in effect.parameters]
    every = (*record.effects, *record.measurement)
    return Model(
        torque_model,
        np.array([row.value for row in rows]),
        _covariance_of(record, len(rows)),
        np.array([row.source == "estimated" for row in rows]),
        is_feasible=record.is_feasible,
        validity=None
        if record.validity is None
        else Ranges(*(bounds_of(getattr(record.validity, x)) for x in RANGES)),
        origin=Origin(**msgspec.to_builtins(record.origin)),
        shapes=tuple(
            tuple(ShapeEstimate(**msgspec.to_builtins(s)) for s in e.shapes) for e in every
        ),
    )


def _check_parameters(record: ModelRecord, effects: Sequence[Effect]) -> None:
    for number, (own, effect) in enumerate(zip(record.effects, effects, strict=True)):
        said, meant = ([p.name for p in x] for x in (own.parameters, effect.parameters))
        if said != meant:
            raise ModelFileError(
                f"effects[{number}]: its parameters are {', '.join(said)}, those of {effect.name} "
                f"are {', '.join(meant)}"
            )


def _parameter_records(model: Model) -> list[ParameterRecord]:
    return [
        ParameterRecord(
            name=parameter.name,
            unit=parameter.unit,
            joint=parameter.joint,
            value=float(value),
            std=None if np.isnan(std) else float(std),
            source="estimated" if own else "regrouped" if value == 0 else "given",
        )
        for parameter, value, std, own in zip(
            model.torque_model.parameters, model.parameters, model.std, model.estimated, strict=True
        )
    ]


def _shape_records(shapes: Sequence[ShapeEstimate]) -> list[ShapeRecord]:
    return [msgspec.convert(shape, ShapeRecord, from_attributes=True) for shape in shapes]


def _covariance_record(model: Model) -> CovarianceRecord | None:
    if model.covariance is None:
        return None
    columns = np.flatnonzero(model.estimated)
    matrix = model.covariance[np.ix_(columns, columns)]
    return CovarianceRecord(columns=columns.tolist(), matrix=matrix.tolist())


def _covariance_of(record: ModelRecord, count: int) -> ndarray | None:
    if record.covariance is None:
        return None
    columns, whole = record.covariance.columns, np.zeros((count, count))
    shape = {len(record.covariance.matrix), *(len(row) for row in record.covariance.matrix)}
    if shape != {len(columns)} or not all(0 <= column < count for column in columns):
        raise ModelFileError(
            f"covariance is damaged: {len(columns)} of {count} parameters, rows of {sorted(shape)}"
        )
    matrix = np.array(record.covariance.matrix)
    if len(set(columns)) < len(columns) or not _is_covariance(matrix):
        raise ModelFileError("covariance is damaged: no errors of different parameters vary so")
    whole[np.ix_(columns, columns)] = matrix
    return whole


def _is_covariance(matrix: ndarray) -> bool:
    """Whether a matrix is symmetric and without a negative variance in any direction."""
    std = np.sqrt(np.diag(matrix).clip(min=np.finfo(float).tiny))
    correlations = matrix / np.outer(std, std)
    is_symmetric = np.allclose(correlations, correlations.T, rtol=0.0, atol=ROUNDING)
    return bool(is_symmetric and np.linalg.eigvalsh(correlations).min(initial=0.0) > -ROUNDING)
