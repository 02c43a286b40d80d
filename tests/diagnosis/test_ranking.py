"""Which candidates are looked at closely."""

import dataclasses

import numpy as np

from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.terms.scores import score
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

FALL = stribeck(0.4, joint=1)


def test_what_acts_on_a_joint_alone_is_not_crowded_out_by_what_acts_on_more():
    """The first joint lacks far more, of which candidates with columns in both take a share."""

    def extra(q, dq, ddq):
        ripple = 3.0 * np.sin(9 * q[:, 0])
        return FALL(q, dq, ddq) + np.stack([ripple, np.zeros(len(q))], axis=1)

    shop = shop_of(data_set(2, extra=extra))
    ripple = trial_of(shop, "torque_ripple", 0, (9.0, 1.0))
    own = trial_of(shop, "stribeck", 1, (0.1, 2.0, 0.0))
    # Under two names of the second joint, where they have nothing to say.
    both = {0: ripple.group[0], 1: np.zeros_like(ripple.group[0])}
    crowd = [
        dataclasses.replace(ripple, name=name, target=1, group=both)
        for name in ("torque_ripple", "position_dependent_friction")
    ]
    fit = shop.before.fit
    assert min(score(t, fit).gain for t in crowd) > score(own, fit).gain > 0
    found = ranked(shop, [*crowd, own], (), 1, thorough=True)
    assert own.key in {s.trial.key for s in found}
