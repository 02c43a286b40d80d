"""Names of which too much of their joint has none; and names that fell for nothing."""

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.verdict import FoundEffect, Unexplained
from oed.diagnosis.evidence.withheld import Errors, withheld
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.selection import _foretelling_most
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of


@pytest.fixture(scope="module")
def sprung():
    def pulled(q, dq, ddq):
        return np.stack([0 * q[:, 0], 0.4 * q[:, 1]], axis=1)

    shop = shop_of(data_set(1, extra=pulled), surrogates=39, refined=4)
    spring = trial_of(shop, "joint_spring", 1)
    return shop, Selection.of(shop, [Accepted(spring, 100.0)], [])


@pytest.mark.parametrize(
    ("gain", "errors", "curve_on", "claimed"),
    [
        (0.3, (4.0, 5.0, 0, 0), 1, False),  # a third, and the joint still lacks five floors
        (0.3, (4.0, 5.0, 0, 0), 0, True),  # another joint lacks something
        (0.3, (4.0, 1.5, 0, 0), 1, True),  # it lacks little
        (0.3, (1.5, 5.0, 0, 0), 1, True),  # it lacks little where the arm has been
        (0.8, (4.0, 5.0, 0, 0), 1, True),  # without the name it would lack 25
        (None, (4.0, 5.0, 0, 0), 1, True),  # nobody can say
        (-0.01, (1.0, 1.0, 0, 0), 1, False),  # it foretells nothing
        (0.5, (1.0, 1.0, 6.0, 5.0), 0, False),  # the test shows that most of it is something else
        (0.5, (1.0, 1.0, 9.0, 5.0), 0, True),  # it shows that there is more, but less
        (0.5, (1.0, 1.0, 1.5, 1.4), 0, True),  # nothing: it moves the joint too little
    ],
)
def test_a_name_is_claimed_if_it_explains_far_more_than_is_lacking(
    sprung, gain, errors, curve_on, claimed
):
    shop, selection = sprung
    (item,) = selection.accepted
    effect = FoundEffect("joint_spring", 1, (), 1e-6, gain, (), item.trial)
    curve = Unexplained(curve_on, ("q_1", "dq_2"), 0.5, "f(q_1, dq_2)", stands_in=True)
    own = np.arange(2) == 1
    seen, unseen, before, after = (np.where(own, x, 1.0) for x in errors)
    found = Errors(seen, unseen, before, after, np.ones(2))
    effects, unexplained = withheld(shop, selection, [effect], (curve,), found)
    assert [e.name for e in effects] == ["joint_spring"] * claimed
    assert unexplained[0] is curve
    for u in unexplained[1:]:
        assert (u.joint, u.depends_on, u.trial) == (1, ("q_2",), item.trial)
        assert u.stands_in
        assert 0 < u.share <= 1
    assert len(unexplained) == 2 - claimed


@pytest.mark.parametrize(("p_value", "claimed"), [(1e-4, True), (0.03, False)])
def test_a_name_that_chance_may_give_beside_all_others_is_not_claimed(sprung, p_value, claimed):
    shop, selection = sprung
    (item,) = selection.accepted
    effect = FoundEffect("joint_spring", 1, (), p_value, 0.5, (), item.trial)
    level = np.ones(2)
    found = Errors(level, level, level, level, level)
    effects, unexplained = withheld(shop, selection, [effect], (), found)
    assert len(effects) == claimed
    assert len(unexplained) == 1 - claimed


def test_what_lies_between_two_joints_is_claimed_if_neither_contradicts_it(sprung):
    shop, _ = sprung
    coupling = trial_of(shop, "motor_coupling", (1, 0), (0.5, 2.0))
    selection = Selection.of(shop, [Accepted(coupling, 100.0)], [])
    effect = FoundEffect("motor_coupling", 1, (), 1e-6, 0.5, (), coupling)
    ones = np.ones(2)
    for joint in range(2):
        before, after = (np.where(np.arange(2) == joint, x, 1.0) for x in (6.0, 5.0))
        errors = Errors(ones, ones, before, after, ones)
        assert withheld(shop, selection, [effect], (), errors)[0] == ()
    errors = Errors(ones, ones, np.full(2, 6.0), ones, ones)
    assert withheld(shop, selection, [effect], (), errors)[0] == (effect,)


@pytest.mark.parametrize(
    ("name", "explained", "left", "claimed"),
    [
        ("payload_change", 0.9, 3.0, False),
        ("payload_change", 1.1, 3.0, True),
        ("payload_change", 0.9, 1.0, True),  # a floor may be read too low by as much
        ("time_delay", 0.9, 3.0, True),  # nothing that rings for a while looks like it
    ],
)
def test_a_load_explains_more_than_is_left(sprung, name, explained, left, claimed):
    shop, _ = sprung
    arm = next(t for t in shop.physical if t.name == name)
    selection = Selection.of(shop, [Accepted(arm, 100.0)], [])
    effect = FoundEffect(name, None, (), 1e-6, 0.5, (), arm)
    ones = np.ones(2)
    # Squares above the noise, of the second joint.
    seen, fitted = (np.sqrt([1.0, 1.0 + x]) for x in (left, left + explained * left))
    errors = Errors(seen, ones, ones, ones, fitted)
    kept, without = withheld(shop, selection, [effect], (), errors)
    assert kept == ((effect,) if claimed else ())
    assert [u.joint for u in without] == ([] if claimed else [1])


@pytest.mark.parametrize(
    ("curves", "claimed"),
    [
        ({0: ("q_1", "q_2"), 1: ("q_1", "q_2")}, False),  # a magnet pulls at the tool
        ({0: ("q_1", "q_2")}, True),  # the other joint shows the tilt alone
        ({0: ("q_1", "q_2"), 1: ("q_1", "dq_2")}, True),  # no weight depends on speed
    ],
)
def test_a_tilt_is_not_claimed_where_something_else_pulls_at_every_joint(sprung, curves, claimed):
    shop, _ = sprung
    tilt = next(t for t in shop.physical if t.name == "gravity_direction")
    selection = Selection.of(shop, [Accepted(tilt, 100.0)], [])
    effect = FoundEffect("gravity_direction", None, (), 1e-6, 0.06, (), tilt)
    unexplained = tuple(Unexplained(j, on, 0.4, "f", stands_in=True) for j, on in curves.items())
    ones = np.ones(2)
    kept, without = withheld(
        shop, selection, [effect], unexplained, Errors(ones, ones, ones, ones, 9 * ones)
    )
    assert kept == ((effect,) if claimed else ())
    assert len(without) == len(curves) + (not claimed)


@pytest.mark.parametrize("name", ["time_delay", "gravity_direction", "payload_change"])
def test_a_name_of_the_whole_arm_must_foretell_something_as_others_must(sprung, name):
    shop, _ = sprung
    arm = next(t for t in shop.physical if t.name == name)
    selection = Selection.of(shop, [Accepted(arm, 100.0)], [])
    effect = FoundEffect(name, None, (), 1e-6, -0.01, (), arm)
    small = Errors(*(np.full(2, 1.0) for _ in range(5)))
    kept, without = withheld(shop, selection, [effect], (), small)
    assert kept == ()
    assert [u.trial for u in without] == [arm]


def test_names_fall_only_for_what_foretells_about_as_much(sprung):
    shop, selection = sprung
    named, nothing = list(selection.accepted), []
    assert _foretelling_most([(shop, nothing), (shop, named)])[1] is named
    assert _foretelling_most([(shop, named), (shop, nothing)])[1] is named
    again = list(named)
    assert _foretelling_most([(shop, again), (shop, named)])[1] is again


@pytest.mark.parametrize(("in_test", "names"), [(0.8, ["torque_offset"]), (-0.8, []), (0.0, [])])
def test_names_that_the_test_recording_contradicts_are_none(in_test, names):
    """It chose nothing, so that what only seems to be there has no reason to show in it."""
    sizes = iter((0.8, 0.8, in_test))

    def offset(q, dq, ddq):
        return np.broadcast_to([next(sizes), 0.0], q.shape)

    dataset = data_set(1, extra=offset, roles=("estimation", "validation", "test"))
    settings = DiagnosisSettings(surrogates=39, bootstrap=40, candidates=("torque_offset",))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert [effect.name for effect in found.effects] == names
    assert all(np.mean((p.after / p.before) ** 2) <= 1 for p in found.proof)
    assert ("torque_offset" in {r.name for r in found.refused}) is (not names)


@pytest.mark.parametrize(("late", "claimed"), [("time_delay", False), ("gravity_direction", True)])
def test_a_name_of_the_whole_arm_is_none_beside_its_like_that_is_none(sprung, late, claimed):
    """A gear foretells nothing: what is late may be the rest of what it is not."""
    shop, _ = sprung
    gear = trial_of(shop, "joint_elasticity", 1)
    arm = next(t for t in shop.physical if t.name == late)
    selection = Selection.of(shop, [Accepted(t, 100.0) for t in (gear, arm)], [])
    effects = [
        FoundEffect(t.name, t.joint, (), 1e-6, gain, (), t)
        for t, gain in ((gear, -0.01), (arm, 0.3))
    ]
    small = Errors(*(np.full(2, 1.0) for _ in range(5)))
    kept, without = withheld(shop, selection, effects, (), small)
    assert [e.name for e in kept] == [late] * claimed
    assert [u.trial for u in without] == [gear, *([] if claimed else [arm])]


@pytest.mark.parametrize(("after_start", "std", "claimed"), [(0.05, 0.3, False), (0.6, 0.3, True)])
def test_a_load_that_comes_as_the_recordings_begin_is_not_claimed(after_start, std, claimed):
    """What friction holds at a start is told by nothing before it."""
    shop = shop_of(data_set(1), surrogates=39, refined=4)
    moment, *_ = CATALOGUE["payload_change"].shapes_for(shop.context, None)
    load = trial_of(shop, "payload_change", None, (moment.lower + after_start, 0.0))
    selection = Selection.of(shop, [Accepted(load, 100.0)], [])
    told = (Estimated("moment", moment.lower + after_start, std, "s"),)
    effect = FoundEffect("payload_change", None, told, 1e-6, 0.3, (), load)
    ones = np.ones(2)
    effects, _ = withheld(shop, selection, [effect], (), Errors(ones, ones, ones, ones, 2 * ones))
    assert [e.name for e in effects] == ["payload_change"] * claimed
