"""What a name must still stand up to once it has been found."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.turning import HEAVIER, moment_fault
from oed.diagnosis.evidence import final_model
from oed.diagnosis.evidence.doubt import doubtful_name
from oed.diagnosis.evidence.final_model import (
    _white_squares,
    final_with,
    fit_final,
    install,
    lost_when_repeated,
)
from oed.diagnosis.search.review import drop_needless, review_names
from oed.diagnosis.search.standing_in import next_free_form
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import at_rest
from oed.diagnosis.terms.scores import implausible, scan, score
from oed.dynamics.effects.catalogue import CATALOGUE
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

THINNED = 0.2  # [rad/s] at which grease thins


def thinning(q, dq, ddq):
    """Eyring's law in the place of part of the viscous friction of the first joint."""
    eased = 3.0 * (0.5 * np.arcsinh(dq[:, 0] / THINNED) - dq[:, 0])
    return np.stack([eased, np.zeros(len(q))], axis=1)


@cache
def shop_with(extra=None):
    return shop_of(data_set(3, extra=extra), held=False)


def test_shapes_stay_where_the_name_can_be_meant():
    """Near the straight line a bend explains most, by the difference of two huge frictions."""
    shop = shop_with(thinning)
    fit = shop.before.fit
    pool = [t for t in shop.physical if t.key == ("nonlinear_viscous", 0)]
    best = max((score(t, fit) for t in pool), key=lambda s: s.gain)
    (found,) = scan(pool, fit, shop.context)
    refined = at_rest(found, fit, shop.context)
    assert implausible(refined, shop.context) is None
    assert refined.gain >= found.gain
    # It costs next to nothing of what is explained.
    assert refined.gain > 0.95 * best.gain
    assert refined.evidence(shop.full.rows.count) > 100


@pytest.mark.parametrize(("deviations", "doubted"), [(2.0, True), (12.0, False)])
def test_a_name_whose_own_interval_holds_zero_is_doubted(deviations, doubted):
    shop = shop_with()
    trial = trial_of(shop, "rotor_inertia", 0)
    found = Augmented(
        (trial,),
        (np.array([0.1]),),
        shop.before.fit,
        (np.array([[(0.1 / deviations) ** 2]]),),
    )
    assert (doubtful_name(shop, found) is trial) is doubted


@pytest.mark.parametrize(("deviations", "doubted"), [(1.5, True), (12.0, False)])
def test_a_torque_that_may_not_be_late_at_all_is_not_called_late(deviations, doubted):
    """Its size is its time: there is no coefficient that could be zero."""
    shop = shop_with()
    trial = trial_of(shop, "time_delay", None, (4e-3,))
    (shape,) = CATALOGUE["time_delay"].shapes_for(shop.context, None)
    on_axis = 4e-3 / deviations / shape.slope_at(4e-3)
    found = Augmented((trial,), (np.ones(1),), shop.before.fit, (np.array([[on_axis**2]]),))
    assert (doubtful_name(shop, found) is trial) is doubted


def test_an_uncertain_shape_does_not_make_a_size_doubtful():
    shop = shop_with()
    trial = trial_of(shop, "torque_ripple", 0, (7.0,))
    # At the shape that it has the size is known to 0.01; over all shapes only to 0.1.
    size, shape = 0.01**2, 1.0
    slope = np.array([0.1, 0.0])
    covariance = np.block(
        [
            [size * np.eye(2) + np.outer(slope, slope), slope[:, None]],
            [slope[None], shape * np.eye(1)],
        ]
    )
    found = Augmented((trial,), (np.array([0.2, 0.0]),), shop.before.fit, (covariance,))
    assert doubtful_name(shop, found) is None


@pytest.mark.parametrize("turned", [False, True])
def test_what_makes_every_repetition_worse_is_lost(turned):
    shop = shop_with(stribeck(1.0))
    trial = trial_of(shop, "stribeck", 0, (0.1, 1.0, 0.5))
    layout = shop.layout_for([trial])
    found = shop.fit([trial], layout)
    final = fit_final(shop.baseline, layout, install(shop.baseline, found, shop.context))
    if turned:
        signs = np.ones(len(final.parameters))
        signs[-1] = -1.0
        final = dataclasses.replace(final, parameters=signs * final.parameters)
    assert (lost_when_repeated(shop, found, final) is trial) is turned


@pytest.mark.parametrize(("elsewhere", "lost"), [(50.0, False), (5.0, True)])
def test_what_moves_the_links_is_judged_by_all_joints_that_carry_them(monkeypatch, elsewhere, lost):
    """Behind a gear that gives way: the joint's own error rises by ten, that of the next falls."""
    shop = shop_with(stribeck(1.0))
    trial = trial_of(shop, "joint_elasticity", 0)
    found = shop.fit([trial])
    final = final_with(shop, found)
    squares = {True: np.array([110.0, 100.0]), False: np.array([100.0, 100.0 + elsewhere])}
    monkeypatch.setattr(final_model, "_white_squares", lambda _, model: squares[model is final])
    assert (lost_when_repeated(shop, found, final) is trial) is lost


@pytest.mark.parametrize(
    ("roles", "lost"),
    [
        (("estimation", "estimation", "validation"), True),
        (("estimation", "validation", "validation"), False),
    ],
)
def test_what_is_lost_is_decided_by_all_repetitions_foretold_ones_too(roles, lost):
    """An effect of the validation recordings alone: it mends these and spoils the others alike."""
    seen, unseen = (data_set(4, extra=extra, roles=roles) for extra in (None, stribeck(1.0)))
    pairs = zip(seen.recordings, unseen.recordings, strict=True)
    mixed = tuple(a if a.role == "estimation" else b for a, b in pairs)
    shop = shop_of(dataclasses.replace(seen, recordings=mixed))
    trial = trial_of(shop, "stribeck", 0, (0.1, 2.0, 1.0))
    layout = shop.layout_for([trial])
    found = shop.fit([trial], layout)
    final = fit_final(shop.baseline, layout, install(shop.baseline, found, shop.context))
    parameters = final.parameters.copy()
    parameters[-1] = 1.0
    final = dataclasses.replace(final, parameters=parameters)
    assert (lost_when_repeated(shop, found, final) is trial) is lost


def test_a_late_sensor_is_not_held_against_single_repetitions():
    shop = shop_with()
    trial = trial_of(shop, "time_delay", None, (0.03,))
    layout = shop.layout_for([trial])
    found = shop.fit([trial], layout)
    final = fit_final(shop.baseline, layout, install(shop.baseline, found, shop.context))
    assert final.fit.squares > shop.before.fit.squares
    assert lost_when_repeated(shop, found, final) is None


def test_what_mends_a_name_does_not_make_it_doubtful():
    """A free form of the same coordinate can follow the name whole: neither is determined alone."""
    shop = shop_with()
    trial = trial_of(shop, "position_dependent_friction", 0, (1.0,))
    free = {t.key[0]: t for t in (*shop.smooth, *shop.smooth_pairs) if t.joint == 0}

    def is_doubtful(label):
        chosen = (trial, free[label])
        counts = [len(t.effect.parameters) for t in chosen]
        found = Augmented(
            chosen,
            tuple(np.full(count, 0.1) for count in counts),
            shop.before.fit,
            (np.eye(counts[0] + 1), np.eye(counts[1])),
        )
        return doubtful_name(shop, found) is trial

    assert not is_doubtful("f(q_1) sgn(dq_1)")
    assert is_doubtful("f(q_2)")


@pytest.mark.parametrize(
    ("repetitions", "clear_by", "doubted"), [(1, 4.5, True), (1, 5.5, False), (3, 4.5, False)]
)
def test_a_torque_that_comes_first_is_clear_of_what_a_control_answers(
    repetitions, clear_by, doubted
):
    """In single motions encoder noise comes before the torque that answers it; in their mean it is gone."""
    shop = shop_of(data_set(1, repetitions=repetitions), held=False)
    lead = trial_of(shop, "time_delay", None, (-0.002,))
    (shape,) = CATALOGUE["time_delay"].shapes_for(shop.context, None)
    deviation = 0.002 / clear_by / shape.slope_at(-0.002)
    found = Augmented((lead,), (np.ones(1),), shop.before.fit, (np.array([[deviation**2]]),))
    assert (doubtful_name(shop, found) is lead) is doubted


def test_a_tilt_of_nothing_with_a_first_moment_of_anything_is_refused():
    shop = shop_with()
    # A level arm shows neither first moment of its first link; a tilted one does.
    columns = np.array([1, 2, 9])
    seen = dataclasses.replace(shop.baseline, columns=columns)
    level = dataclasses.replace(shop.baseline, columns=np.array([9]))
    tilted = _Turned(seen, level)
    inertia = 2.5
    declared = float(shop.declared.model.robot.parameters[::10].sum())
    heaviest = np.sqrt(HEAVIER * declared * inertia)
    for moment, refused in ((0.9 * heaviest, False), (1.1 * heaviest, True)):
        parameters = np.array([moment, 0.0, inertia])
        fit = dataclasses.replace(shop.before.fit, parameters=parameters)
        assert (moment_fault(tilted, fit) is not None) is refused


class _Turned(Workshop):
    """Tables of which only the two baselines matter."""

    def __init__(self, baseline, declared):
        self.baseline, self.declared = baseline, declared


def test_rivals_act_on_the_same_joint():
    shop = shop_with()
    trial = trial_of(shop, "rotor_inertia", 0)
    targets = {(t.name, t.joint) for t in shop.in_place_of(trial)}
    assert ("stribeck", 0) in targets
    assert ("time_delay", None) in targets
    assert ("stribeck", 1) not in targets


def test_an_offset_of_a_tether_is_not_named_beside_the_tether():
    """A free form found beside an offset leaves it its part, which it does as well by itself."""

    def tether(q, dq, ddq):
        stretch = q[:, 1] + 1.1 * q[:, 0] + 0.4
        pull = 0.15 * (stretch + np.sqrt(stretch**2 + 0.03**2))
        return np.stack([np.zeros(len(q)), pull], axis=1)

    shop = shop_of(data_set(5, extra=tether))
    offset = Accepted(trial_of(shop, "torque_offset", 1), 1.0)
    tether_term = next_free_form(shop, [offset], [])
    assert tether_term is not None
    assert tether_term.trial.effect.depends_on == ("q_1", "q_2")
    assert tether_term.stands_in
    layout = shop.mean
    both, alone = (
        shop.fit(chosen, layout).fit.squares
        for chosen in ([offset.trial, tether_term.trial], [tether_term.trial])
    )
    # As it is, it could not do without the offset.
    assert alone > 2 * both
    refused = []
    assert review_names(shop, [offset, tether_term], refused) == [tether_term]
    assert [r.name for r in refused] == ["torque_offset"]


def test_a_curve_of_the_model_is_not_needless_beside_one_that_is_not_part_of_it():
    def curved(q, dq, ddq):
        return np.stack([np.sin(q[:, 0]), np.zeros(len(q))], axis=1)

    shop = shop_with(curved)
    own = next(t for t in shop.smooth if t.key == ("f(q_1)", 0))
    pair = next(t for t in shop.smooth_pairs if t.key == ("f(q_1, dq_1)", 0))
    aside = Accepted(pair, 1.0, stands_in=False)
    curve, refused = Accepted(own, 1e4), []
    left = drop_needless(shop, [curve, aside], refused)
    # Beside the pair it would be needless; but the pair is no part of the model.
    beside = score(own, shop.fit([pair], shop.mean).fit)
    assert beside.evidence(shop.full.rows.count) < 0
    assert curve in left


def test_a_coupling_is_held_against_the_repetitions_of_both_its_joints():
    """Its inertia is far below the noise of the first joint, and clear at the second."""

    def shared(q, dq, ddq):
        return 0.008 * ddq[:, ::-1]

    shop = shop_of(data_set(5, extra=shared), held=False)
    found = shop.fit([trial_of(shop, "motor_coupling", (0, 1), (0.0, 2.0))])
    model = install(shop.baseline, found, shop.context)
    final = fit_final(shop.baseline, shop.mean, model)
    assert lost_when_repeated(shop, found, final) is None


def test_a_curve_of_its_joint_is_no_reason_why_repetitions_lose_a_name():
    """Friction that grows with the square of speed one way: the curve follows that, the name most of it."""

    def one_way(q, dq, ddq):
        return np.stack([0.5 * dq[:, 0] ** 2, np.zeros(len(q))], axis=1)

    shop = shop_of(data_set(6, extra=one_way))
    name = trial_of(shop, "asymmetric_viscous", 0)
    curve = next(t for t in shop.smooth if t.key == ("f(dq_1)", 0))
    found = shop.fit([name, curve])
    final = final_with(shop, found)
    alone = final_with(shop, shop.fit([curve]))
    assert _white_squares(shop, alone)[0] <= _white_squares(shop, final)[0] + 1.0
    assert lost_when_repeated(shop, found, final) is None
