"""Formulas of more terms, where the data ask for them; and curves of no more coordinates than needed."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.judgement import share_needed
from oed.diagnosis.candidates.usual import plainer
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.search.review import drop_needless, review_names
from oed.diagnosis.search.selection import search
from oed.diagnosis.search.standing_in import next_free_form
from oed.diagnosis.search.two_at_once import two_at_once
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.terms.climbing import refine
from oed.diagnosis.terms.scores import score
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import COULOMB, VISCOUS, data_set, rigid
from tests.diagnosis.shop import shop_of, trial_of

RIVALS = (
    "joint_spring",
    "position_dependent_friction",
    "torque_offset",
    "torque_ripple",
    "joint_elasticity",
    "encoder_eccentricity",
)
SETTINGS = DiagnosisSettings(surrogates=39, bootstrap=40, refined=4, candidates=RIVALS)


def on_first(torque):
    """Torque of the first joint's position alone."""
    return lambda q, dq, ddq: np.stack([torque(q[:, 0]), np.zeros(len(q))], axis=1)


def found_in(torque, **changes):
    dataset = data_set(3, extra=on_first(torque), **changes)
    return diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)


def test_a_spring_that_tightens_and_an_uneven_ripple_of_one_joint_are_both_named():
    found = found_in(
        lambda q: 1.5 * (q + 1.2 * q**3) + 0.8 * np.sin(14 * q) + 0.4 * np.sin(28 * q + 1)
    )
    assert {(e.name, e.joint) for e in found.effects} == {("joint_spring", 0), ("torque_ripple", 0)}
    assert found.verdict == "explained"
    values = {p.name: p for e in found.effects for p in e.parameters}
    assert values["harmonic"].value == pytest.approx(14, abs=0.1)
    assert values["spring3_1"].value == pytest.approx(1.8, abs=4 * values["spring3_1"].std)
    waves = [p.value for name, p in values.items() if name.startswith("ripple")]
    assert np.linalg.norm(waves[2:]) == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize(("formula", "multiples"), [(3.0, (1, 2, 3)), (4.0, (1, 2, 0.5))])
def test_a_ripple_of_three_waves_has_all_of_them(formula, multiples):
    sizes = np.array([0.6, 0.35, 0.2])

    def ripple(q):
        waves = zip(sizes, multiples, strict=True)
        return sum(size * np.sin(k * 9 * q + k) for size, k in waves)

    shop = shop_of(data_set(5, extra=on_first(ripple)), held=False)
    start = score(trial_of(shop, "torque_ripple", 0, (8.9, 1.0)), shop.before.fit)
    found = refine(start, shop.before.fit, shop.context)
    assert found.trial.values == pytest.approx((9.0, formula), abs=0.05)
    amplitudes = np.linalg.norm(found.coefficients.reshape(3, 2), axis=1)
    # The band takes some of what is fast; a wave's noise is a few hundredths.
    assert amplitudes == pytest.approx(sizes, abs=0.06)


def test_a_spring_in_pieces_has_plainer_formulas_and_a_plain_one_none():
    shop = shop_of(data_set(5, extra=on_first(lambda q: 2.0 * q)), held=False)
    plain = plainer(shop, (), trial_of(shop, "joint_spring", 0, (3.0,)))
    assert plain is not None
    assert plain.values in {(1.0,), (2.0,)}
    found = score(plain, shop.before.fit)
    assert found.coefficients[0] == pytest.approx(2.0, abs=0.1)
    assert plainer(shop, (), trial_of(shop, "joint_spring", 0, (1.0,))) is None
    assert plainer(shop, (), trial_of(shop, "torque_offset", 0)) is None


def test_a_spring_that_pushes_is_none_by_any_formula():
    shop = shop_of(data_set(5, extra=on_first(lambda q: -2.0 * q)), held=False)
    assert plainer(shop, (), trial_of(shop, "joint_spring", 0, (3.0,))) is None


@pytest.mark.parametrize(
    ("name", "values"), [("joint_spring", (1.0,)), ("torque_ripple", (9.0, 1.0))]
)
def test_a_plain_formula_stays_where_nothing_more_is_there(name, values):
    torque = {"joint_spring": lambda q: 2.0 * q, "torque_ripple": lambda q: 0.6 * np.sin(9 * q)}
    shop = shop_of(data_set(5, extra=on_first(torque[name])), held=False)
    start = score(trial_of(shop, name, 0, values), shop.before.fit)
    assert refine(start, shop.before.fit, shop.context).trial.values[-1] == 1.0
    fuller = score(trial_of(shop, name, 0, (*values[:-1], 2.0)), shop.before.fit)
    assert refine(fuller, shop.before.fit, shop.context).trial.values[-1] == 1.0


def test_a_curve_of_one_coordinate_stands_before_one_of_two():
    """A dent at one place of the turn; other motions reach further."""
    found = found_in(lambda q: -6.0 * (q - 0.3) * np.exp(-(((q - 0.3) / 0.12) ** 2)), near=0.7)
    assert [u.depends_on for u in found.unexplained if u.joint == 0] == [("q_1",)]


def test_a_name_that_a_curve_makes_needless_is_not_claimed():
    """The first joint's motion drags the second, a little more the further that is bent."""
    shop = shop_of(
        data_set(
            3,
            extra=lambda q, dq, ddq: np.stack(
                [0 * q[:, 0], (1 + 0.15 * q[:, 1]) * dq[:, 0]], axis=1
            ),
        )
    )
    fit, refused = shop.before.fit, []
    curve = next(t for t in shop.smooth if t.joint == 1 and t.key[0] == "f(q_2) dq_1")
    drag = trial_of(shop, "motor_coupling", (1, 0))
    both = [Accepted(t, score(t, fit).gain) for t in (drag, curve)]
    # It explains 98 % of what both do, but the curve has no need of it.
    assert both[0].gain > 0.95 * both[1].gain
    assert review_names(shop, both, refused) == both[1:]
    assert [r.name for r in refused] == ["motor_coupling"]


def test_a_curve_that_nothing_asks_for_any_more_is_dropped():
    shop = shop_of(data_set(5, extra=on_first(lambda q: 2.0 * q)), held=False)
    fit, refused = shop.before.fit, []
    curve = next(t for t in shop.smooth if t.joint == 0 and t.key[0] == "f(q_1)")
    spring = trial_of(shop, "joint_spring", 0)
    alone, both = ([Accepted(t, score(t, fit).gain) for t in x] for x in ([curve], [spring, curve]))
    assert drop_needless(shop, alone, refused) == alone
    assert drop_needless(shop, both, refused) == both[:1]
    assert [r.name for r in refused] == ["f(q_1)"]


def wrong_by_waves(recording, size, waves):
    """The same where the first encoder reads so that q + size sin(waves q) is the true angle."""
    q, true = recording.q.copy(), recording.q[:, 0]
    for _ in range(20):
        q[:, 0] = true - size * np.sin(waves * q[:, 0])
    return dataclasses.replace(recording, q=q)


@pytest.mark.parametrize("waves", [5, 6])
def test_an_encoder_that_errs_several_times_a_turn_is_named(waves):
    dataset = data_set(5)
    recordings = tuple(wrong_by_waves(r, 4e-3, waves) for r in dataset.recordings)
    wrong = dataclasses.replace(dataset, recordings=recordings)
    (found,) = diagnose(wrong, TorqueModel.standard(wrong.robot), SETTINGS).effects
    values = {p.name: p for p in found.parameters}
    assert (found.name, found.joint) == ("encoder_eccentricity", 0)
    wave = values[f"encoder{waves}_sin_1"]
    assert wave.value == pytest.approx(4e-3, abs=4 * wave.std)


def test_one_candidate_is_no_pair():
    shop = shop_of(data_set(5, extra=on_first(lambda q: 2.0 * q)), held=False)
    assert two_at_once(shop, [], [trial_of(shop, "joint_spring", 0)], 0, []) == []


def test_a_name_must_explain_what_a_share_of_another_torque_does():
    shop = shop_of(data_set(5))
    share = next(t for t in shop.smooth if t.is_share and t.joint == 0)
    curve = next(t for t in shop.smooth if not t.is_share and t.joint == 0)
    named = trial_of(shop, "rotor_inertia", 0)
    assert share_needed([share], named, SETTINGS) == 1.0
    assert share_needed([curve], named, SETTINGS) < 1.0


def sawtooth(q):
    return 0.6 * (2 * (3 * q / np.pi % 1) - 1)


def teeth_of_two_gears(q):
    return 1.2 * np.sin(12 * q) + 0.5 * np.sin(24 * q + 1) + 0.9 * np.sin(9 * q + 2)


def detent(q):
    """It holds at one place of the turn."""
    return 2.0 * (q - 0.07) / 0.18 * np.exp(-(((q - 0.07) / 0.18) ** 2))


@pytest.mark.parametrize(
    ("torque", "is_wave"), [(sawtooth, True), (teeth_of_two_gears, True), (detent, False)]
)
def test_a_ripple_comes_back_along_the_range(torque, is_wave):
    found = found_in(torque)
    assert [e.name for e in found.effects] == ["torque_ripple"] * is_wave
    assert ("q_1",) in [u.depends_on for u in found.unexplained if u.joint == 0]


def test_what_pulls_at_a_position_and_grows_with_time_depends_on_both():
    """A hose that another joint bends, and that fills: each recording begins with it empty."""

    def hose(q, dq, ddq):
        filled = np.arange(len(q)) / len(q)
        return np.stack([4.0 * filled * np.sin(q[:, 1] - 0.3), 0 * filled], axis=1)

    dataset = data_set(3, extra=hose)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    assert found.effects == ()
    assert {"time", "q_2"} in [set(u.depends_on) for u in found.unexplained if u.joint == 0]
    # Of what is missing, at least the 70 % that a form without a name has to remove.
    test = next(p for p in found.proof if p.role == "test")
    before, after = (
        np.sqrt(error[0] ** 2 - found.noise_floor[0] ** 2) for error in (test.before, test.after)
    )
    assert after < 0.3 * before


def test_the_search_goes_on_where_no_tilt_is_found():
    """A level arm shows under a tilt what it hides else; a spring is explained with impossible links."""

    def extra(q, dq, ddq):
        uneven = 0.6 * np.cos(4 * q[:, 0] + 2.4) * np.sign(dq[:, 0])
        return np.stack([1.65 * (q[:, 0] - 0.2) + uneven, 0 * q[:, 0]], axis=1)

    names = ("gravity_direction", "joint_spring", "position_dependent_friction")
    _, selection = search(shop_of(data_set(3, extra=extra), candidates=names))
    found = {(a.trial.name, a.trial.joint) for a in selection.accepted}
    assert found == {("joint_spring", 0), ("position_dependent_friction", 0)}


def test_a_cable_that_is_slack_in_the_middle_is_a_spring_and_nothing_else():
    """Coarse stretches leave some of it that has no name, or passes for a ripple."""

    def slack(q):
        return 4.0 * np.sign(q - 0.06) * np.maximum(np.abs(q - 0.06) - 0.14, 0.0)

    found = found_in(slack)
    assert {(e.name, e.joint) for e in found.effects} == {("joint_spring", 0)}
    assert found.verdict == "explained"


def test_a_reading_that_ends_at_a_limit_is_a_saturation_and_nothing_else():
    limit = 20.0  # N m; the joint needs about 25

    def cut(q, dq, ddq):
        torque = rigid(q, dq, ddq) + COULOMB * np.sign(dq) + VISCOUS * dq
        return (np.clip(torque, -limit, limit) - torque) * [1, 0]

    dataset = data_set(3, extra=cut)
    settings = dataclasses.replace(SETTINGS, candidates=tuple(CATALOGUE))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert {(e.name, e.joint) for e in found.effects} == {("torque_saturation", 0)}
    assert found.verdict == "explained"
    values = {p.name: p.value for p in found.effects[0].parameters}
    peak = float(found.shop.context.peak_torque[0])
    assert peak * (1 - 1 / values["exponent"]) == pytest.approx(limit, rel=0.02)
    # No curve of a power goes on beyond what was fitted as a limit does.
    test = next(p for p in found.proof if p.role == "test")
    assert (test.after / found.noise_floor).max() < 1.1


def test_a_gear_that_turns_back_more_easily_is_friction_under_load_and_no_gain():
    """Two losses are their mean, and half their difference times the load, as a gain is."""
    driving, driven = 0.14, 0.04

    def gear(q, dq, ddq):
        load = rigid(q, dq, ddq)
        loss = np.where(load * dq > 0, driving, driven) * np.abs(load) * np.sign(dq)
        return loss * [1, 0]

    dataset = data_set(3, extra=gear)
    settings = dataclasses.replace(SETTINGS, candidates=tuple(CATALOGUE))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert {(e.name, e.joint) for e in found.effects} == {("load_dependent_friction", 0)}
    assert found.verdict == "explained"
    told = {p.name: p for p in found.effects[0].parameters}
    for name, value in (("mu_1", driving), ("mu_driven_1", driven)):
        assert told[name].value == pytest.approx(value, abs=4 * told[name].std)
        assert told[name].std < 0.02


def test_a_spring_beside_a_much_larger_ripple_of_its_joint_is_named():
    """It explains a fiftieth of what the ripple does, and no curve of position does as well."""
    names = ("torque_ripple", "joint_spring")
    torque = on_first(lambda q: 2.4 * np.sin(16 * q) + 0.5 * np.sin(32 * q) + 0.6 * q)
    shop = shop_of(data_set(3, extra=torque), candidates=names)
    _, found = search(shop)
    assert {t.key for t in found.trials} == {(name, 0) for name in names}


def test_a_curve_does_not_stand_in_where_nothing_is_foretold():
    """Without validation recordings, and without repetitions, it may follow slow noise."""

    def bump(q, dq, ddq):
        return np.stack([4.0 * np.exp(-((q[:, 0] / 0.3) ** 2)), np.zeros(len(q))], axis=1)

    roles = ("estimation", "estimation", "validation")
    dataset = data_set(3, extra=bump, repetitions=1, roles=roles)
    for held in (True, False):
        found = next_free_form(shop_of(dataset, held=held, surrogates=39, refined=4), [], [])
        assert found is not None
        assert found.trial.joint == 0
        assert found.stands_in is held
