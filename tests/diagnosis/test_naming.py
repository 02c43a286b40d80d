"""What stays of a selection once every effect has its exact form."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.evidence.final_model import fit_final
from oed.diagnosis.evidence.naming import named
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.terms.scores import score
from oed.dynamics.velocity_sign import widths_of, with_widths
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of


def biased(*sizes):
    """A constant torque on each joint [N m]."""
    return lambda q, dq, ddq: np.broadcast_to(sizes, q.shape)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_of_additions_the_one_goes_that_raises_the_validation_error(order):
    """An offset that was gone when the validation recordings were made, whichever came last."""
    own, later = data_set(4, extra=biased(2.0, 1.0)), data_set(5, extra=biased(2.0, 0.0))
    recordings = (*own.estimation, *(r for r in later.recordings if r.role == "validation"))
    shop = shop_of(dataclasses.replace(own, recordings=recordings))
    accepted, others = [], []
    for joint in order:
        trial = trial_of(shop, "torque_offset", joint)
        found = score(trial, shop.fit(others, shop.mean).fit)
        accepted.append(Accepted(trial, found.gain))
        others.append(trial)
    selection = Selection.of(shop, accepted, [])
    before = fit_final(shop.declared, shop.mean, shop.declared.model)
    shop, kept, after, effects = named(shop, selection, shop.validation, before)
    assert [t.key for t in kept.trials] == [("torque_offset", 0)]
    assert [(e.name, e.joint) for e in effects] == [("torque_offset", 0)]
    assert len(after.model.parameters) == len(before.model.parameters) + 1
    (refused,) = kept.refused
    assert (refused.name, refused.joint) == ("torque_offset", 1)
    assert "validation error" in refused.reason


def test_other_names_outlive_a_law_of_speed_and_the_sign_that_had_turned_to_suit_it():
    """Without the law the slow sign is wrong by its whole size, whatever else is named."""
    sharp = shop_of(data_set(4, extra=biased(0.0, 0.06)), surrogates=19)
    slow = with_widths(sharp.baseline.model, [0.12, *sharp.baseline.least_widths[1:]])
    shop = sharp.on(sharp.baseline.with_model(slow, sharp.estimation))
    offset, law = trial_of(shop, "torque_offset", 1), trial_of(shop, "stribeck", 0, (0.05, 1.0))
    assert shop.fit([offset, law]).coefficients[1][0] > 1.0  # N m, for want of a sharp sign
    selection = Selection.of(shop, [Accepted(t, 1e3) for t in (offset, law)], [])
    before = fit_final(shop.declared, shop.mean, sharp.declared.model)
    there, _, _, effects = named(shop, selection, shop.validation, before)
    assert [(e.name, e.joint) for e in effects] == [("torque_offset", 1)]
    assert max(widths_of(there.baseline.model)) < 0.01
