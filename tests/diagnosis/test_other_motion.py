"""Names that only the validation recordings show."""

import numpy as np
import pytest

from oed.diagnosis.search.next_name import next_names
from oed.diagnosis.search.other_motion import shown_by_other_motion
from oed.diagnosis.search.selection import search
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of

NAMES = ("nonlinear_viscous", "stribeck", "torque_offset", "joint_spring")
NEAR = 0.38  # times as far and as fast as other motions do those for estimation go
EXPONENT = 3.0


def stirred(q, dq, ddq):
    """Friction of the second joint that hardly shows in slow motion."""
    own = 1.0 * np.sign(dq[:, 1]) * np.abs(dq[:, 1] / 3.0) ** EXPONENT
    return np.stack([np.zeros(len(q)), own], axis=1)


def shop_with(extra):
    dataset = data_set(3, extra=extra, near=NEAR)
    return shop_of(dataset, surrogates=99, refined=4, candidates=NAMES)


@pytest.fixture(scope="module")
def fast():
    return shop_with(stirred)


def test_what_the_other_motion_alone_shows_is_found_in_it(fast):
    refused = []
    (found,) = shown_by_other_motion(fast, [], set(), refused)
    assert found.trial.key == ("nonlinear_viscous", 1)
    # The exponent, and the speed from which on friction rises less, trade places.
    assert found.trial.values[0] == pytest.approx(EXPONENT, abs=0.5)
    # On the rows of the shop that asked.
    assert found.trial.group[1].shape[0] == fast.mean.rows.count


def test_no_name_that_may_not_come(fast):
    barred: set[tuple[str, object]] = {("nonlinear_viscous", 1)}
    found = shown_by_other_motion(fast, [], barred, [])
    assert all(a.trial.key not in barred for a in found)


def test_nothing_is_looked_for_in_what_is_foretold_well():
    refused = []
    shop = shop_with(None)
    assert shown_by_other_motion(shop, [], set(), refused) == []
    assert not refused


def test_a_search_takes_it_up(fast):
    refused = []
    assert next_names(fast, [], refused, fast.physical) == []  # its own motion does not show it
    _, selection = search(fast)
    assert [t.key for t in selection.trials] == [("nonlinear_viscous", 1)]
    before, after = (shop_left(fast, chosen) for chosen in ((), selection.trials))
    assert before > 4.0
    assert after < 1.5


def shop_left(shop, chosen):
    """Root mean square of what is foretold of the second joint, in noises."""
    unseen = shop.unseen_by(chosen)
    return np.sqrt(unseen.left(shop.fit(chosen, bend=False))[1] / unseen.counted[1])
