"""What each addition gives, held against what was put into the data."""

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.evidence.contributions import (
    ContributionCurve,
    ContributionMap,
    contributions,
)
from oed.diagnosis.evidence.final_model import fit_final, install
from oed.diagnosis.search.selected import Selection
from tests.diagnosis.arm import NOISE, data_set
from tests.diagnosis.shop import shop_of, trial_of

OFFSET = 0.8  # [N m]


def with_offset_and_field(q, dq, ddq):
    """On joint 1 a constant, on joint 2 what hangs on both positions: no base column has either."""
    del dq, ddq
    return np.stack([np.full(len(q), OFFSET), field(q[:, 0], q[:, 1])], axis=1)


def field(q1, q2):
    return 0.4 * np.cos(2 * q1) * np.cos(2 * q2)


def free(shop, label, joint):
    pool = (*shop.smooth, *shop.smooth_pairs)
    return next(t for t in pool if t.key[0] == label and t.joint == joint)


@pytest.fixture(scope="module")
def shop():
    return shop_of(data_set(13, extra=with_offset_and_field))


def shown(shop, *, stands_in):
    named = Accepted(trial_of(shop, "torque_offset", 0), 1.0)
    free_form = Accepted(free(shop, "f(q_1, q_2)", 1), 1.0, stands_in=stands_in)
    selection = Selection.of(shop, [named, free_form], ())
    layout = shop.layout_for(selection.trials)
    model = install(shop.baseline, selection.found, shop.context)
    after = fit_final(shop.baseline, layout, model)
    return contributions(shop, selection, after, NOISE)


@pytest.mark.parametrize("stands_in", [True, False])
def test_contributions_are_what_was_put_in(shop, stands_in):
    constant, over_both = shown(shop, stands_in=stands_in)

    assert isinstance(constant, ContributionCurve)
    assert constant.given.joint == 0
    # Friction and inertia can give a little of a constant on this motion: that is in neither.
    assert np.mean(constant.given.mean) == pytest.approx(OFFSET, abs=0.05)
    assert np.max(np.abs(constant.given.mean - OFFSET)) < 0.25 * OFFSET
    # The dots are the data: off by noise, which their own deviation tells.
    off = np.abs(constant.missing.mean - constant.given.mean)
    assert np.mean(off < 3 * constant.missing.deviation) > 0.8

    assert isinstance(over_both, ContributionMap)
    assert (over_both.joint, over_both.coordinates) == (1, ("q_1", "q_2"))
    first, second = ((e[1:] + e[:-1]) / 2 for e in over_both.edges)
    true = field(*np.meshgrid(first, second, indexing="ij"))
    seen = np.isfinite(over_both.given)
    assert 10 < seen.sum() < seen.size
    # Four pieces a coordinate follow two cosines roughly, and inertia can give a part of them.
    slope, _ = np.polyfit(true[seen], over_both.given[seen], 1)
    assert slope == pytest.approx(1.0, abs=0.25)
    assert np.corrcoef(over_both.given[seen], true[seen])[0, 1] > 0.85
