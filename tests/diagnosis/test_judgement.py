"""What an addition may cost at one joint for what it wins at another."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates import paying
from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.judgement import PRICE, WORSE, costs
from oed.diagnosis.candidates.leftovers import too_little
from oed.diagnosis.candidates.open_shapes import shapes_beside
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence import naming
from oed.diagnosis.search import selection
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.terms.climbing import at_rest
from oed.diagnosis.terms.scores import score
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import COULOMB, RATE, VISCOUS, data_set, rigid, stribeck
from tests.diagnosis.shop import shop_of, trial_of

FLOOR = np.array([0.5, 0.1])
OLD = np.array([1.0, 0.2])
ROWS = np.full(2, 300.0)


def test_falling_errors_cost_nothing():
    assert not costs(OLD, np.array([0.9, 0.19]), FLOOR, ROWS)
    assert not costs(OLD, np.array([0.9, 0.19]), FLOOR, ROWS, price=0.0)


def test_errors_that_rise_together_do():
    assert costs(OLD, np.array([1.01, 0.2]), FLOOR, ROWS)


# What may take the place of something that is even in speed, without what is dear to evaluate.
FRICTION = (
    "asymmetric_viscous",
    "torque_offset",
    "nonlinear_viscous",
    "stribeck",
    "presliding_hysteresis",
    "load_dependent_friction",
    "joint_spring",
    "gravity_direction",
    "torque_gain",
)


@pytest.mark.parametrize(("share", "dear"), [(0.9 * PRICE, False), (1.1 * PRICE, True)])
def test_a_loss_is_weighed_against_the_gain_as_likelihoods_are(share, dear):
    new = np.array([0.6, OLD[1] * (OLD[0] / 0.6) ** share])
    assert np.mean((new / OLD) ** 2) < 1
    assert new[1] > WORSE * OLD[1]
    assert costs(OLD, new, FLOOR, ROWS) is dear
    assert costs(OLD, new, FLOOR, ROWS, price=0.0)


def test_rows_of_slow_noise_count_as_the_few_that_they_are():
    new = np.array([0.6, OLD[1] * (OLD[0] / 0.6) ** (1.1 * PRICE)])
    assert costs(OLD, new, FLOOR, ROWS)
    assert not costs(OLD, new, FLOOR, ROWS * [1.0, 0.5])
    old, new = np.array([FLOOR[0], 10 * FLOOR[1]]), np.array([0.7 * FLOOR[0], 10.5 * FLOOR[1]])
    assert costs(old, new, FLOOR, ROWS)
    assert not costs(old, new, FLOOR, ROWS * [1.0, 0.04])  # 0.51 of the first's, and 10 of these


def test_no_more_is_lost_than_won_in_squares_of_the_floor():
    """A joint whose error is many floors loses more by a tenth than another wins by a third."""
    old, new = np.array([FLOOR[0], 10 * FLOOR[1]]), np.array([0.7 * FLOOR[0], 10.5 * FLOOR[1]])
    assert not costs(FLOOR, new * FLOOR / old, FLOOR, ROWS)
    assert costs(old, new, FLOOR, ROWS)


def test_an_error_that_falls_to_nothing_outweighs_one_that_rises_by_a_half():
    old, floor = np.array([7.0, 4.0]) * FLOOR, FLOOR
    new = old * [0.2, 1.6]
    assert np.mean((new / old) ** 2) > 1
    assert not costs(old, new, floor, ROWS)
    assert costs(old, old * [0.7, 1.6], floor, ROWS)


def test_a_rise_within_the_margin_is_chance():
    new = np.array([0.6, (WORSE - 0.001) * OLD[1]])
    assert not costs(OLD, new, FLOOR, ROWS, price=0.0)


def test_an_addition_is_judged_beside_shapes_that_have_settled():
    """Friction at a wrong shape foretells its joint badly, with an offset of another or without."""

    def extra(q, dq, ddq):
        return stribeck(1.5)(q, dq, ddq) + np.array([0.0, 0.5])

    shop = shop_of(data_set(10, extra=extra))
    wrong = trial_of(shop, "stribeck", 0, (0.5, 4.0, 0.0))
    offset = trial_of(shop, "torque_offset", 1)
    (moved,) = shapes_beside(shop, [wrong], offset, [0])
    before, after = shop.foretold([wrong, offset], [moved, offset])
    assert before is not None
    assert after is not None
    assert after[0] < 0.7 * before[0]
    assert after == pytest.approx(shop.baseline.floor.deviation, rel=0.25)
    assert shapes_beside(shop, [offset], wrong, [0, 1]) == []
    assert shapes_beside(shop, [wrong], offset, [1]) == []


def test_an_error_below_the_noise_loses_no_more_than_the_noise():
    """The first joint wins a third; the second had luck."""
    old = np.array([1.5, 0.6]) * FLOOR
    assert not costs(old, np.array([1.0, 1.1]) * FLOOR, FLOOR, ROWS * [1.0, 0.5])
    assert costs(old, np.array([1.0, 1.32]) * FLOOR, FLOOR, ROWS * [1.0, 0.5])
    # Of its full rise the sum must fall all the same.
    assert costs(old, np.array([1.0, 1.1]) * FLOOR, FLOOR, ROWS)


def saturating(limit, gain):
    """What a drive commands beside the joints' torque: it saturates in one, errs in the other."""

    def extra(q, dq, ddq):
        torque = rigid(q, dq, ddq) + COULOMB * np.sign(dq) + VISCOUS * dq
        first = limit * np.arctanh(np.clip(torque[:, 0] / limit, -0.999, 0.999))
        return np.stack([first, (1 + gain) * torque[:, 1]], axis=1) - torque

    return extra


@pytest.mark.parametrize("gain", [0.0, 0.02, 0.05])
def test_a_gain_is_not_what_the_formula_of_another_joints_saturation_lacks(gain):
    shop = shop_of(data_set(1, extra=saturating(80.0, gain)))
    start = score(trial_of(shop, "torque_saturation", 0), shop.before.fit)
    first = at_rest(start, shop.before.fit, shop.context)
    beside = shop.fit([first.trial]).fit
    found = score(trial_of(shop, "torque_gain", 1), beside)
    # Noise alone makes no gain of half a hundredth: the saturation has another formula.
    assert found.coefficients == pytest.approx([gain], abs=0.008)
    reason = too_little(shop, found, [Accepted(first.trial, first.gain)])
    assert (reason is None) == (gain > 0)


def test_two_plain_effects_of_one_kind_are_two():
    """Both are even in speed, and where the joint seldom rests one does most of the other's work."""

    def lopsided(q, dq, ddq):
        return np.stack([0.35 * np.abs(dq[:, 0]) + 0.4, np.zeros(len(q))], axis=1)

    dataset = data_set(1, extra=lopsided)
    settings = dataclasses.replace(
        DiagnosisSettings(), surrogates=39, bootstrap=40, refined=4, candidates=FRICTION
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert {(e.name, e.joint) for e in found.effects} == {
        ("asymmetric_viscous", 0),
        ("torque_offset", 0),
    }
    assert not found.unexplained


def test_a_wrong_formula_is_not_mended_by_an_offset():
    """What a parabola leaves of the friction that it is: a function of speed explains it best."""

    def curved(q, dq, ddq):
        extra = 0.3 * np.where(dq[:, 0] > 0, dq[:, 0], 0.0) ** 2
        return np.stack([extra, np.zeros(len(q))], axis=1)

    dataset = data_set(1, extra=curved)
    settings = dataclasses.replace(
        DiagnosisSettings(), surrogates=39, bootstrap=40, refined=4, candidates=FRICTION
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert [(e.name, e.joint) for e in found.effects] == [("asymmetric_viscous", 0)]


def test_a_name_that_foretells_less_than_nothing_goes(monkeypatch):
    own = paying.validation_gain

    def harmed(shop, standing, trial):
        return -0.05 if trial.name == "torque_offset" else own(shop, standing, trial)

    offset = np.array([0.8, 0.0])
    dataset = data_set(1, extra=lambda q, dq, ddq: offset + np.zeros_like(q))
    names = ("torque_offset", "joint_spring", "stribeck")
    settings = dataclasses.replace(
        DiagnosisSettings(), surrogates=39, bootstrap=40, candidates=names
    )
    model = TorqueModel.standard(dataset.robot)
    assert [e.name for e in diagnose(dataset, model, settings).effects] == ["torque_offset"]
    monkeypatch.setattr(naming, "validation_gain", harmed)
    found = diagnose(dataset, model, settings)
    assert not found.effects
    assert "torque_offset" in {r.name for r in found.refused}


def test_friction_that_rises_from_standstill_is_told_beside_friction_of_the_position():
    """A curve of the speed would mend the formula of the latter, and explain much less."""

    def extra(q, dq, ddq):
        torque = stribeck(2.0, speed=0.05)(q, dq, ddq)
        torque[:, 0] += 2.0 * np.cos(1.5 * q[:, 0] + 0.4) * np.sign(dq[:, 0])
        return torque

    names = ("stribeck", "position_dependent_friction")
    _, found = selection.search(shop_of(data_set(5, extra=extra), candidates=names))
    assert {a.trial.key for a in found.accepted} == {(name, 0) for name in names}


def test_a_change_between_repetitions_is_judged_beside_what_a_curve_would_mend():
    """The curve has the rows of a mean repetition, the change those of all of them."""

    def extra(q, dq, ddq):
        cold = np.exp(-np.arange(len(q)) / RATE / 10.0)
        return np.stack([3.0 * q[:, 0] + 0.8 * cold * np.sign(dq[:, 0]), 0 * cold], axis=1)

    names = ("joint_spring", "thermal_drift")
    _, found = selection.search(shop_of(data_set(5, extra=extra), candidates=names))
    assert {a.trial.key for a in found.accepted} == {(name, 0) for name in names}
