"""The model that each way of finding one hands on."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from oed.estimation.calibration import Calibration
from oed.estimation.known_torque import KnownTorque
from oed.export.model import Model, Origin, Ranges, ShapeEstimate
from oed.report.provenance import Provenance

if TYPE_CHECKING:  # what finds one kind of model need not load what finds the others
    from oed.diagnosis.diagnose import Diagnosis
    from oed.diagnosis.inference.answer import FoundEffect
    from oed.estimation.feasible.calibration import FeasibleCalibration


def of_calibration(
    calibration: Calibration, provenance: Provenance, started: Model | None = None
) -> Model:
    """Base parameters by least squares; what they stand for is zero.

    Args:
        calibration: That found them.
        provenance: Of the run.
        started: The model that it started from, None for a named one.
    """
    estimate, base = calibration.estimate, calibration.base
    columns = base.columns[list(estimate.columns)]
    count = len(calibration.model.parameters)
    parameters, covariance = np.zeros(count), np.zeros((count, count))
    parameters[columns] = estimate.parameters
    covariance[np.ix_(columns, columns)] = estimate.covariance
    found = Model(
        calibration.model,
        parameters,
        covariance,
        np.isin(np.arange(count), columns),
        is_feasible=False,
        validity=_ranges(calibration),
        origin=_origin("oed identify", calibration.dataset.name, estimate.method, provenance),
    )
    return _completed(found, calibration.known, started)


def of_feasible(
    result: FeasibleCalibration, provenance: Provenance, started: Model | None = None
) -> Model:
    """All parameters, of bodies that can exist; covariance of resampled estimates."""
    estimate = result.estimate
    found = Model(
        estimate.model,
        estimate.parameters,
        np.cov(result.bootstrap.samples.T),
        np.ones(len(estimate.parameters), dtype=bool),
        is_feasible=True,
        validity=_ranges(result.plain),
        origin=_origin(
            "oed feasible",
            result.plain.dataset.name,
            f"feasible least squares; covariance: {result.bootstrap.method}",
            provenance,
        ),
    )
    return _completed(found, result.plain.known, started)


def _completed(found: Model, known: KnownTorque, started: Model | None) -> Model:
    """With what was not estimated anew, and what is known of shapes."""
    torque_model = found.torque_model.with_effects(*known.effects)
    count = len(known.parameters)
    covariance = None if found.covariance is None else np.pad(found.covariance, (0, count))
    return dataclasses.replace(
        found,
        torque_model=torque_model,
        parameters=np.concatenate([found.parameters, known.parameters]),
        covariance=covariance,
        estimated=np.concatenate([found.estimated, np.zeros(count, dtype=bool)]),
        shapes=() if started is None else started.shapes_of(torque_model),
    )


def of_diagnosis(
    found: Diagnosis, data: str, provenance: Provenance, started: Model | None = None
) -> Model:
    """The augmented model: base parameters, effects in their exact form, smooth terms.

    Args:
        found: Of a data set.
        data: Its name.
        provenance: Of the run.
        started: The model that it started from, None for a named one.
    """
    from oed.diagnosis.inference.covariance import (  # noqa: PLC0415
        parameter_covariance,
    )

    model = found.after.model
    covariance = parameter_covariance(found.selected.views.told)
    prepared = found.selected.views.told.problem.rows.prepared
    whole = Model(
        model,
        found.after.parameters,
        covariance,
        np.diag(covariance) > 0,
        is_feasible=False,
        validity=Ranges.of([p.motion for p in prepared], [p.torque for p in prepared]),
        origin=_origin(
            "oed diagnose",
            data,
            "penalised least squares of base model and additions; covariance by blocks of rows",
            provenance,
        ),
    )
    whole = _completed(whole, found.known, started)
    return dataclasses.replace(whole, shapes=_shapes(whole, found.effects))


def _shapes(
    whole: Model, effects: tuple[FoundEffect, ...]
) -> tuple[tuple[ShapeEstimate, ...], ...]:
    """Nonlinear parameters of what was found, at the effect that has its name and joint.

    Those of an effect that was there before stay.
    """
    model = whole.torque_model
    names = {parameter.name for parameter in model.parameters}

    def own(
        name: str, joint: int | None, before: tuple[ShapeEstimate, ...]
    ) -> tuple[ShapeEstimate, ...]:
        found = next((e for e in effects if (e.name, e.joint) == (name, joint)), None)
        return (
            before
            if found is None
            else tuple(
                ShapeEstimate(p.name, p.unit, p.value, p.std, p.note)
                for p in found.parameters
                if p.name not in names
            )
        )

    every = (*model.effects, *model.measurement)
    shapes = whole.shapes or ((),) * len(every)
    return tuple(
        own(effect.name, getattr(effect, "joint", None), before)
        for effect, before in zip(every, shapes, strict=True)
    )


def _ranges(calibration: Calibration) -> Ranges:
    training = calibration.recordings["estimation"]
    return Ranges.of([r.motion for r in training], [r.tau for r in training])


def _origin(command: str, data: str, method: str, provenance: Provenance) -> Origin:
    return Origin(
        command=command,
        data=data,
        method=method,
        date=provenance.date,
        commit=provenance.commit,
        seed=provenance.seed,
        versions=provenance.versions,
    )
