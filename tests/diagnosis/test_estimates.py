"""Deviations of a term's sizes and shapes against the whole model's covariance, worked out at once."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.evidence.columns import white_effect
from oed.diagnosis.evidence.views import Views
from oed.diagnosis.inference.estimates import estimates
from oed.diagnosis.selection.screen import evaluate
from oed.diagnosis.selection.tables import as_term
from oed.diagnosis.setup import pose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck

SPEED, DILUTION = 0.15, 3.0


@pytest.fixture(scope="module")
def whole():
    """Stribeck's law, and a curve over speed that would take much of it up if its prior did not hold it."""
    dataset = data_set(33, repetitions=1, extra=stribeck(1.5, SPEED))
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("stribeck",))[0]
    start = Views.of(problem, (), "all")
    law = next(c for c in problem.names if c.label == "stribeck@1")
    curve = next(c for c in problem.smooth if c.label == "f(dq_1)[11]@1")
    terms = [evaluate(c, v, start.means) for c, v in ((law, (SPEED, 2.0, 0.0)), (curve, ()))]
    known, bent = (as_term(t) for t in terms if t is not None)
    assert bent.precision is not None
    held = dataclasses.replace(bent, precision=1e4 * bent.precision)
    return start.grown((known, held), "all").told


def _slopes(whole):
    """White torque's derivative by each shape of the law that is estimated, over all rows."""
    rows, size = whole.problem.rows, float(whole.size(0)[0])
    candidate, values = whole.terms[0].candidate, np.array(whole.terms[0].values)
    columns = []
    for k in (0, 1):
        step = np.zeros(3)
        step[k] = 1e-3 * values[k]
        high, low = (
            white_effect(candidate.effect(whole.context, tuple(v)), whole.installed, rows)[0]
            for v in (values + step, values - step)
        )
        columns.append(size * (high - low)[:, 0] / (2 * step[k]))
    return np.stack(columns, axis=1)


def _deviations(information):
    lengths = np.sqrt(np.diag(information))
    covariance = np.linalg.inv(information / np.outer(lengths, lengths))
    return np.sqrt(DILUTION * np.diag(covariance)) / lengths


def test_deviations_are_those_of_all_parameters_together(whole):
    projection = whole.projection
    slopes = np.zeros((2, projection.columns.shape[1], 2))
    slopes[0] = _slopes(whole)
    J = np.concatenate([projection.columns, slopes], axis=2)[:, projection.used]
    J = (J * projection.weights[:, None, None]).reshape(-1, J.shape[2])
    held = np.zeros((J.shape[1], J.shape[1]))
    held[whole.places[1], whole.places[1]] = whole.terms[1].precision
    std = _deviations(J.T @ J + held)
    free = _deviations(J.T @ J + held / 1e4)
    found = estimates(whole, 0, DILUTION)
    assert [p.name for p in found] == ["Fs_1", "speed", "exponent", "tail"]
    assert std[whole.places[0].start] < 0.7 * free[whole.places[0].start]
    expected = (std[whole.places[0].start], std[-2], std[-1])
    for own, value in zip(found, expected, strict=False):
        assert own.std == pytest.approx(value, rel=0.01)
    assert found[3].std is None
