"""Test recordings speak against a name by the rows that tell of it."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.diagnose import _contradicted, predictor
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.evidence.views import Views
from oed.diagnosis.inference.answer import Answer, FoundEffect
from oed.diagnosis.selection.substitutes import ahead
from oed.diagnosis.setup import Sealed, pose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck


class _Halved(Sealed):
    """What is known of noise says that rows of the second half tell nothing."""

    def weights(self, prepared):
        first = [np.arange(p.rows)[p.valid] < p.rows / 2 for p in prepared]
        return [np.repeat(own[:, None], 2, axis=1).astype(float) for own in first]


@pytest.mark.parametrize(("counts", "is_contradicted"), [(True, True), (False, False)])
def test_only_rows_that_count_contradict_a_name(counts, is_contradicted):
    """Test recordings go thrice as far the other way where rows count, or where they do not."""
    dataset = data_set(31, extra=stribeck(1.5, 0.15), repetitions=2)
    base = TorqueModel.standard(dataset.robot)
    problem, sealed, _ = pose(dataset, base, names=("stribeck",))
    halved = _Halved(sealed.every, sealed.before, sealed.baseline)
    start = Views.of(problem, (), "fitted")
    law = next(c for c in problem.names if c.label == "stribeck@1")
    views = start.grown((Term(law, (0.15, 2.0, 1.0)),), "all")
    after = predictor(ahead(views, views.terms).told)
    without = predictor(ahead(views, ()).told)
    effect = FoundEffect("stribeck", 0, 0, 1.0, (), (), 1.0, 1.0, law.entry.page)
    told = []
    for own in sealed.every:
        if own.role == "test":
            away = 3.0 * (without.torque(own) - after.torque(own))
            away[(np.arange(own.rows) < own.rows / 2) != counts] = 0.0
            told.append(dataclasses.replace(own, torque=after.torque(own) + away))
    found = _contradicted(views, Answer((effect,), ()), told, halved, after)
    assert bool(found) is is_contradicted
