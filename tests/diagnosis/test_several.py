"""One effect in several joints at once, and a search that comes to an end."""

import numpy as np
import pytest

from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.usual import as_usual
from oed.diagnosis.evidence.doubt import doubtful_name
from oed.diagnosis.search import name_search, selection
from oed.diagnosis.search.several import several_at_once
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.terms.scores import score
from oed.diagnosis.terms.trials import catalogue_trial
from oed.dynamics.effects.catalogue import CATALOGUE
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of

OFFSETS = np.array([0.8, -0.3])  # [N m]


def offsets(joints):
    def torque(q, dq, ddq):
        return np.broadcast_to(np.where(np.isin(range(2), joints), OFFSETS, 0.0), q.shape)

    return torque


def kind(shop, name):
    return [t for t in shop.physical if t.name == name]


def test_every_joint_that_needs_it_gets_it():
    shop = shop_of(data_set(5, extra=offsets([0, 1])))
    found = several_at_once(shop, [], kind(shop, "torque_offset"), [])
    assert {a.trial.key for a in found} == {("torque_offset", 0), ("torque_offset", 1)}
    assert all(a.stands_in for a in found)
    sizes = shop.fit([a.trial for a in found]).coefficients
    assert np.concatenate(sizes) == pytest.approx(OFFSETS, abs=0.05)


@pytest.mark.parametrize("joints", [[], [0], [1]])
def test_one_joint_alone_is_no_kind(joints):
    shop = shop_of(data_set(5, extra=offsets(joints)))
    refused = []
    assert several_at_once(shop, [], kind(shop, "torque_offset"), refused) == []
    assert refused == []


def test_plain_effects_of_one_joint_are_found_though_a_curve_outdoes_each_alone():
    """On joint 2 an offset and a rotor, each as large as the other."""

    def torque(q, dq, ddq):
        return np.stack([0 * q[:, 0], 0.3 + 0.12 * ddq[:, 1]], axis=1)

    rivals = ("asymmetric_viscous", "joint_spring", "torque_gain", "gravity_direction")
    names = ("torque_offset", "rotor_inertia", *rivals)
    shop = shop_of(data_set(5, extra=torque, repetitions=1), candidates=names)
    _, found = selection.search(shop)
    sizes = {
        t.key: float(c[0]) for t, c in zip(found.trials, found.found.coefficients, strict=True)
    }
    assert set(sizes) == {("torque_offset", 1), ("rotor_inertia", 1)}
    assert sizes[("torque_offset", 1)] == pytest.approx(0.3, abs=0.05)
    assert sizes[("rotor_inertia", 1)] == pytest.approx(0.12, abs=0.01)


def test_what_falls_beside_the_others_does_not_come_back(monkeypatch):
    """A pick that settling throws out again would be picked for ever."""
    picked = []

    def stubborn(shop, accepted, refused, pool, most=1):
        taken = {a.trial.key for a in accepted}
        for key in (("torque_offset", 0), ("rotor_inertia", 1)):
            for trial in pool:
                if trial.key == key and key not in taken:
                    picked.append(key)
                    return [selection.Accepted(trial, 1.0)]
        return []

    monkeypatch.setattr(name_search, "next_names", stubborn)
    shop = shop_of(data_set(5, extra=offsets([0])), candidates=("torque_offset", "rotor_inertia"))
    _, found = selection.search(shop)
    assert [a.trial.key for a in found.accepted] == [("torque_offset", 0)]
    assert picked == [("torque_offset", 0), ("rotor_inertia", 1)]


def test_a_gear_of_which_nothing_is_known_is_doubted():
    shop = shop_of(data_set(5))
    values = (8.0, 0.05, 0.4, 0.0, 0.0)
    trial = catalogue_trial(CATALOGUE["joint_elasticity"], shop.context, 0, values, shop.mean.rows)
    for deviations, doubted in (((0.4,) * 5, True), ((0.01, 0.4, 0.4, 0.4, 0.4), False)):
        covariance = np.diag(np.square(deviations))
        found = Augmented((trial,), (np.ones(1),), shop.before.fit, (covariance,))
        assert (doubtful_name(shop, found) is trial) is doubted


def coupled(ratio):
    """The first joint's motor, of whose speed the second joint's share is the ratio."""

    def torque(q, dq, ddq):
        speed, rate = (x[:, 0] + ratio * x[:, 1] for x in (dq, ddq))
        own = 0.05 * rate + 0.3 * speed + 0.5 * np.sign(speed)
        return np.stack([own, ratio * own], axis=1)

    return torque


@pytest.mark.parametrize(("true", "start", "given"), [(1.0, 0.97, 1.0), (0.6, 0.6, 0.6)])
def test_a_usual_ratio_is_taken_unless_the_data_say_another(true, start, given):
    shop = shop_of(data_set(5, extra=coupled(true)))
    fit = shop.before.fit
    entry = CATALOGUE["motor_coupling"]
    trial = catalogue_trial(entry, shop.context, (1, 0), (start, 2.0), shop.mean.rows)
    found = as_usual(shop, [], score(trial, fit), fit)
    assert found.trial.values == (given, 2.0)


@pytest.mark.parametrize("rows", [1, 2])
def test_a_coupling_is_told_by_the_rows_that_show_its_inertia(rows):
    """Motors' torques show it in one; to those of joints both have the same."""

    def coupling(q, dq, ddq):
        other = ddq[:, 1] if rows == 2 else np.zeros(len(q))
        return 0.3 * np.stack([other, ddq[:, 0]], axis=1)

    shop = shop_of(data_set(5, extra=coupling), candidates=("motor_coupling", "torque_gain"))
    found = ranked(shop, shop.physical, (), 3)[0]
    assert found.trial.name == "motor_coupling"
    assert found.trial.target in ([(1, 0)] if rows == 1 else [(1, 0), (0, 1)])
    assert found.trial.values[1] == rows
    assert found.coefficients[0] == pytest.approx(0.3, rel=0.05)


def test_an_arm_may_lack_two_effects_a_joint():
    settings = DiagnosisSettings()
    assert [settings.most_effects(n) for n in (1, 2, 6, 7)] == [4, 4, 12, 14]
    assert [settings.most_free_forms(n) for n in (1, 2, 6, 7)] == [4, 4, 6, 7]
    only = DiagnosisSettings(max_effects=0)
    assert (only.most_effects(6), only.most_free_forms(6)) == (0, 0)
