"""A load that is taken up on one motion explains more than curves; what joints lack, less."""

import numpy as np
import pytest

from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.search.free_form_rivals import curves_explain_more
from tests.diagnosis.arm import PERIOD, data_set
from tests.diagnosis.shop import shop_of

REPEATED, SINGLE = 3, 1
ROLES = (*4 * ("estimation",), "validation")


def pulls(q, dq, ddq):
    """Waves of each joint's position: nothing that begins at a moment."""
    return np.stack([1.5 * np.cos(3 * q[:, 0]), 0.4 * np.sin(4 * q[:, 1])], axis=1)


def picks_up(q, dq, ddq):
    """The torque of a mass that the second link holds for the second half of a motion."""
    held = (np.arange(len(q)) > 0.5 * len(q)).astype(float)
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    # 0.3 kg at 0.3 m from the second axis, the links 0.359 m apart.
    mass, r, length = 0.3, 0.3, 0.359
    inner, cross = mass * r**2, mass * length * r
    first = (mass * length**2 + inner + 2 * cross * c) * ddq[:, 0] + (inner + cross * c) * ddq[:, 1]
    first -= cross * s * dq[:, 1] * (2 * dq[:, 0] + dq[:, 1])
    second = (inner + cross * c) * ddq[:, 0] + inner * ddq[:, 1] + cross * s * dq[:, 0] ** 2
    return held[:, None] * np.stack([first, second], axis=1)


def best_load(extra, repetitions):
    shop = shop_of(
        data_set(5, extra=extra, repetitions=repetitions, roles=ROLES),
        candidates=("payload_change",),
    )
    return shop, ranked(shop, shop.physical, (), 2, thorough=True)[0]


def test_what_joints_lack_is_no_load():
    shop, load = best_load(pulls, SINGLE)
    assert load.gain > 0
    reason = curves_explain_more(shop, load, ())
    assert reason is not None
    assert "curves of the joints" in reason


def test_a_load_is_more_than_curves():
    shop, load = best_load(picks_up, SINGLE)
    assert load.trial.effect.moment == pytest.approx(PERIOD / 2, abs=0.3)
    assert curves_explain_more(shop, load, ()) is None


def test_where_motions_repeat_curves_say_nothing_of_what_differs():
    shop, load = best_load(pulls, REPEATED)
    assert curves_explain_more(shop, load, ()) is None
