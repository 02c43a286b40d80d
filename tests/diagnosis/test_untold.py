"""Base parameters that the fitted rows do not tell are held at zero, by noise and not by what is missing."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.evidence.views import Views
from oed.diagnosis.selection.screen import evaluate
from oed.diagnosis.selection.tables import as_term
from oed.diagnosis.setup import pose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, once

STIFFNESS = 4.0  # [N m/rad]


def _spring(q, dq, ddq):
    result = np.zeros_like(q)
    result[:, 1] = STIFFNESS * (q[:, 1] - 0.3)
    return result


def test_what_the_base_model_lacks_does_not_forbid_the_parameters_that_are_right_beside_it():
    dataset = data_set(11, extra=_spring, near=0.5, repetitions=1)
    dataset = dataclasses.replace(dataset, recordings=tuple(map(once, dataset.recordings)))
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("joint_spring",))[0]
    start = Views.of(problem, (), "fitted")
    candidate = next(c for c in problem.names if c.label == "joint_spring@2")
    tried = (evaluate(candidate, v, start.means) for v in candidate.grid(problem.context))
    best = max((s for s in tried if s is not None), key=lambda s: s.nats)
    grown = start.grown((as_term(best),), "fitted")
    assert grown.left("held_out")[1] < 1.5
    assert grown.means.coefficients[0][0] == pytest.approx(STIFFNESS, rel=0.05)


@pytest.mark.parametrize(("near", "is_told"), [(1.0, True), (0.01, False)])
def test_what_a_motion_hides_below_the_noise_is_held_at_zero(near, is_told):
    dataset = data_set(11, near=near, repetitions=1)
    dataset = dataclasses.replace(dataset, recordings=tuple(map(once, dataset.recordings)))
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("joint_spring",))[0]
    assert is_told is not problem.base_precision.any()
