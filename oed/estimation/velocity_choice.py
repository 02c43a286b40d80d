"""Which velocity the model explains better: that of the differentiated position, or the logged one."""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.stacking import stack
from oed.estimation.streaming import StreamingLeastSquares
from oed.estimation.triangular import unit_columns
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.processed import processed
from oed.experiment.preparation.settings import ProcessingSettings, VelocitySource

SOURCES: tuple[VelocitySource, ...] = ("differentiated", "logged")


def choose_velocity(
    dataset: DataSet, model: TorqueModel, settings: ProcessingSettings
) -> ProcessingSettings:
    """Settings with the velocity, differentiated or logged, that the model explains better.

    A logged velocity can be better than a differentiated one (a drive's own sensor, a delay
    of the position) or worse (coarse steps, an observer's lag): the estimation recordings decide,
    by the product of the joints' residual variances.
    """
    if any(recording.dq is None for recording in dataset.recordings):
        return settings
    base = base_parameters(model)
    scores: dict[VelocitySource, float] = {}
    for source in SOURCES:
        candidate = dataclasses.replace(settings, velocity=source)
        training = tuple(r for p in prepare(dataset.estimation, candidate) for r in processed(p))
        regressor, torque = stack(model, base, training)
        seen = StreamingLeastSquares.of(regressor, torque.ravel())
        _, variances = _identifiable(seen).solve_with_residual_variances()
        scores[source] = float(np.exp(0.5 * np.mean(np.log(variances))))
    best = min(scores, key=scores.__getitem__)
    reason = (
        f"{best}, the residual of the estimation recordings is {scores[best]:.4g} N m "
        f"(geometric mean over joints) against {max(scores.values()):.4g} N m"
    )
    return settings.with_velocity(best, reason)


def _identifiable(seen: StreamingLeastSquares) -> StreamingLeastSquares:
    """Combinations of columns without those that this motion leaves at zero: enough to compare residuals."""
    scaled, norms = unit_columns(seen.factor)
    _, singular_values, right = np.linalg.svd(scaled)
    kept = singular_values > 1e-8 * singular_values[0]
    return seen.of_combinations(right[kept].T / norms[:, None])
