"""Chance is counted where a candidate acts: what another joint lacks is no noise of this one."""

import numpy as np
import pytest
from scipy.stats import gumbel_r

from oed.diagnosis.candidates import chance
from oed.diagnosis.candidates.chance import ROUNDS, chance_of, keeps_step_unseen, p_value_of
from oed.diagnosis.terms.scores import inflation_of, score
from oed.diagnosis_new.noise.linear_fit import LinearFit
from tests.diagnosis.arm import COULOMB, VISCOUS, data_set
from tests.diagnosis.shop import shop_of, trial_of

SHARE = 0.03  # of the first joint's friction that the second one's motor carries
RIPPLE = 0.9  # [N m]


def wavy_and_coupled(q, dq, ddq):
    wave = RIPPLE * (np.sin(4 * q[:, 0] + 0.5) + 0.45 * np.sin(8 * q[:, 0] + 1.1))
    return np.stack(
        [wave, SHARE * (COULOMB[0] * np.sign(dq[:, 0]) + VISCOUS[0] * dq[:, 0])], axis=1
    )


def faint(q, dq, ddq):
    """A constant torque on the second joint that a search may take for chance."""
    return np.broadcast_to([0.0, 0.003], q.shape)


def beside_nothing(shop, trial) -> LinearFit:
    return shop.fit([], shop.layout(trial)).fit


def test_a_joint_that_lacks_much_hides_no_effect_of_another():
    shop = shop_of(data_set(2, extra=wavy_and_coupled), surrogates=99, refined=4)
    trial = trial_of(shop, "motor_coupling", (1, 0), (0.0, 2.0))
    assert set(trial.group) == {0, 1}
    candidate = score(trial, beside_nothing(shop, trial))
    assert p_value_of(shop, candidate, [], shop.physical) < 1e-6


def test_nothing_is_as_likely_as_chance_says():
    """The p-value of the best of all names, where there is none, is seldom small."""
    shop = shop_of(data_set(5), surrogates=99, refined=4)
    best = max(
        (score(t, beside_nothing(shop, t)) for t in shop.physical),
        key=lambda s: s.surprise(np.ones(2)),
    )
    assert p_value_of(shop, best, [], shop.physical) > 0.01


@pytest.mark.parametrize(("value", "rounds"), [(1e-6, 1), (0.3, 1), (0.011, ROUNDS)])
def test_a_chance_near_the_level_is_drawn_more_finely(value, rounds):
    """Surprises of a search through noise have the tail of a largest value."""
    rng, drawn = np.random.default_rng(4), []

    def null():
        drawn.append(gumbel_r.rvs(5.0, 1.5, size=99, random_state=rng))
        return drawn[-1]

    surprise = float(gumbel_r.isf(value / 3, 5.0, 1.5))
    found = chance_of(surprise, null, level=0.01, places=3.0)
    assert len(drawn) == rounds
    if rounds > 1:
        # A tail's slope from 990 draws is known to 3 %, so that chance itself to a fifth.
        assert found == pytest.approx(value, rel=0.5)


def test_an_addition_explains_unseen_recordings_by_their_own_motion(monkeypatch):
    """Recordings are as long as one another: what is made for one would fit the rows of the other."""

    def spring(q, dq, ddq):
        return np.stack([np.zeros(len(q)), 6.0 * q[:, 1]], axis=1)

    left = []

    def misfit(shop, others, joint):
        left.append(inflation_of(shop.fit(others, shop.mean).fit)[joint])
        return False

    monkeypatch.setattr(chance, "keeps_step", misfit)
    roles = ("estimation", "validation")
    shop = shop_of(data_set(4, extra=spring, repetitions=1, roles=roles))
    keeps_step_unseen(shop, [], 1)
    keeps_step_unseen(shop, [trial_of(shop, "joint_spring", 1)], 1)
    without, with_it = left
    assert without > 3
    assert with_it == 1  # at the floor or below: it counts as no lack


def test_a_chance_is_the_same_whatever_was_asked_before():
    """Names are described on several processes, each of which is asked for some."""
    shop = shop_of(data_set(5, extra=faint), surrogates=39, refined=4)
    first, second = (
        score(trial, beside_nothing(shop, trial))
        for trial in (trial_of(shop, "torque_offset", joint) for joint in range(2))
    )
    alone = p_value_of(shop, second, [], shop.physical)
    assert 1e-6 < alone < 0.5  # where another draw would be seen
    p_value_of(shop, first, [], shop.physical)
    assert p_value_of(shop, second, [], shop.physical) == alone
