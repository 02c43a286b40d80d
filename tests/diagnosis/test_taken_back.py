"""Test recordings choose nothing, and take back what they contradict."""

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.evidence.final_model import fit_final
from oed.diagnosis.evidence.naming import named
from oed.diagnosis.finding import Finding, uncontradicted
from oed.diagnosis.search.selected import Selection
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

FALL = stribeck(1.0, joint=1)
BUMP = 1.0  # [N m]


def bumpy(q, dq, ddq):
    """Friction that falls at the second joint, and a bump under the first."""
    bump = BUMP * np.exp(-((q[:, 0] / 0.3) ** 2))
    return FALL(q, dq, ddq) + np.stack([bump, np.zeros(len(q))], axis=1)


@pytest.mark.parametrize(("tested", "stays"), [(FALL, False), (bumpy, True)])
def test_a_curve_that_raises_its_joints_error_stands_aside_and_the_name_beside_it_stays(
    tested, stays
):
    shop = shop_of(data_set(3, extra=bumpy), surrogates=19, candidates=("stribeck",))
    curve = next(t for t in shop.smooth if t.key == ("f(q_1)", 0))
    name = trial_of(shop, "stribeck", 1, (0.1, 2.0, 1.0))
    accepted = [Accepted(t, 1e3) for t in (name, curve)]
    selection = Selection.of(shop, accepted, [])
    before = fit_final(shop.baseline, shop.mean, shop.baseline.model)
    shop, selection, after, effects = named(shop, selection, shop.validation, before)
    assert after.model is not before.model
    found = Finding(shop, selection, before, after, effects)
    recordings = data_set(3, extra=tested).recordings
    test = tuple(p for p in prepare(recordings) if p.role == "test")
    left = uncontradicted(found, shop.validation, test)
    assert [e.name for e in left.effects] == ["stribeck"]
    assert {a.trial.key for a in left.selection.accepted} == {name.key, curve.key}
    assert [a.stands_in for a in left.selection.accepted] == [True, stays]


def sprung(q, dq, ddq):
    """Friction that falls at the second joint, and a spring at the first."""
    return FALL(q, dq, ddq) + np.stack([2.0 * q[:, 0], np.zeros(len(q))], axis=1)


@pytest.mark.parametrize(
    ("tested", "kept"), [(FALL, ["stribeck"]), (sprung, ["joint_spring", "stribeck"])]
)
def test_a_name_that_raises_a_joints_error_goes_alone(tested, kept):
    """All that was added lowers the error by far; the spring is not there when it is tested."""
    shop = shop_of(
        data_set(3, extra=sprung), surrogates=19, candidates=("stribeck", "joint_spring")
    )
    names = [trial_of(shop, "joint_spring", 0), trial_of(shop, "stribeck", 1, (0.1, 2.0, 1.0))]
    selection = Selection.of(shop, [Accepted(t, 1e3) for t in names], [])
    before = fit_final(shop.baseline, shop.mean, shop.baseline.model)
    shop, selection, after, effects = named(shop, selection, shop.validation, before)
    found = Finding(shop, selection, before, after, effects)
    recordings = data_set(3, extra=tested).recordings
    test = tuple(p for p in prepare(recordings) if p.role == "test")
    left = uncontradicted(found, shop.validation, test)
    assert sorted(e.name for e in left.effects) == kept
    gone = {r.name for r in left.selection.refused if r.reason == "it raises the test error"}
    assert gone == {t.name for t in names} - {*kept}
