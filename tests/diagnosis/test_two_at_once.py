"""Two effects of one joint, tried together against what free-form terms make of both."""

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.judgement import judge
from oed.diagnosis.search.two_at_once import two_at_once
from oed.diagnosis.terms.climbing import refine
from oed.diagnosis.terms.scores import score
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of


def on_second_joint(torque):
    def extra(q, dq, ddq):
        return np.stack([np.zeros(len(q)), torque(q, dq)], axis=1)

    return extra


def pair_of(torque, seed=1):
    shop = shop_of(data_set(seed, extra=on_second_joint(torque)), surrogates=39, refined=4)
    return {a.trial.name for a in two_at_once(shop, [], shop.physical, 1, [])}


def test_finds_both_effects_of_a_joint():
    def uneven(q, dq):
        return 0.12 * np.cos(q[:, 1] + 0.4) * np.sign(dq[:, 1]) + 0.1 * np.sin(9 * q[:, 1])

    assert pair_of(uneven) == {"position_dependent_friction", "torque_ripple"}


def test_no_two_names_make_up_what_no_name_covers():
    def landscape(q, dq):
        return 0.15 * np.tanh(3 * (q[:, 0] + q[:, 1])) * np.cos(2 * q[:, 1])

    assert not pair_of(landscape)


def test_one_effect_is_not_made_two():
    assert not pair_of(lambda q, dq: 0.15 * np.sin(9 * q[:, 1]))


def test_nothing_is_nothing():
    assert not pair_of(lambda q, dq: np.zeros(len(q)))


def test_of_two_that_are_all_one_may_be_far_smaller():
    """Beside one that may only be a wrong formula, so little would pass for what that leaves."""

    def loud_and_faint(q, dq):
        return 20.0 * np.sin(9 * q[:, 1]) + 0.12

    dataset = data_set(1, extra=on_second_joint(loud_and_faint))
    shop = shop_of(dataset, surrogates=39, refined=4)
    loud = refine(
        score(trial_of(shop, "torque_ripple", 1, (9.0,)), shop.before.fit),
        shop.before.fit,
        shop.context,
    )
    faint = score(trial_of(shop, "torque_offset", 1), shop.fit([loud.trial]).fit)
    refused = []
    known = [Accepted(loud.trial, loud.gain)]
    assert judge(shop, faint, known, shop.physical, refused) is None
    assert "of what torque_ripple gained" in refused[0].reason
    assert judge(shop, faint, [], shop.physical, refused, partners=[loud.trial]) is not None
