"""A load that every recording takes up at a moment of its own."""

from itertools import count

import numpy as np
import pytest

from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.search.pickups import _is_shown_unseen
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.payload import PickUp
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import LENGTH, RATE, data_set, rigid
from tests.diagnosis.shop import shop_of

MASS, REACH = 1.5, 0.25  # [kg], [m] from the second joint
SETTINGS = DiagnosisSettings(
    surrogates=39, bootstrap=40, candidates=("payload_change", "thermal_drift", "joint_spring")
)


def load_from(moments, mass=MASS):
    """Torque of a point mass on the second link, in each recording from its moment on."""
    numbers = count()

    def torque(q, dq, ddq):
        t = np.arange(len(q)) / RATE
        own = (mass * LENGTH**2, mass * REACH, 0.0, mass * REACH**2)
        return (t >= moments[next(numbers)])[:, None] * rigid(q, dq, ddq, own)

    return torque


@pytest.mark.parametrize(
    ("roles", "moments"),
    [
        (("estimation", "validation", "test"), (13.0, 6.5, 17.2)),
        (("estimation", "estimation", "validation", "test"), (9.0, 15.5, 6.5, np.inf)),
        # Rid of it in between: the arm is then what it was before.
        (("estimation", "validation", "test"), (13.0, np.inf, 17.2)),
    ],
)
def test_a_load_is_found_and_when_each_recording_takes_it_up(roles, moments):
    dataset = data_set(5, extra=load_from(moments), roles=roles)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    (effect,) = found.effects
    assert effect.name == "payload_change"
    values = {p.name: p.value for p in effect.parameters}
    assert values["load_mx_2"] == pytest.approx(MASS * REACH, rel=0.05)
    # A row of the analysis band is about 50 ms long.
    assert values["moment"] == pytest.approx(moments[0], abs=0.05)
    assert len(found.moments) == len(moments) - 1
    for own, true in zip(found.moments.values(), moments[1:], strict=True):
        assert own.value == true or abs(own.value - true) < 4 * own.std
        assert own.std < 0.1
    for proof in found.proof:
        assert np.all(proof.after < 1.2 * found.noise_floor), proof.role


def test_moments_that_are_the_same_are_no_moments_of_their_own():
    dataset = data_set(5, extra=load_from((12.0,) * 3), roles=("estimation", "validation", "test"))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    assert [effect.name for effect in found.effects] == ["payload_change"]
    assert not found.moments


def test_no_moment_is_read_off_noise():
    dataset = data_set(5, roles=("estimation", "validation", "test"))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    assert found.verdict == "nothing found"
    assert not found.moments


@pytest.mark.parametrize(("moment", "is_shown"), [(0.5, True), (np.inf, False)])
def test_a_load_that_comes_again_nowhere_needs_other_proof(moment, is_shown):
    """Validation recordings show it for a while, or an arm that is rid of it."""
    shop = shop_of(data_set(5, roles=("estimation", "validation")))
    (unseen,) = shop.validation
    first, last = (float(unseen.motion.t[k]) for k in (0, -1))
    shop.take_up((PickUp(first, last, first + moment * (last - first)),))
    # What a fit leaves of it: as much as without the load, or far less.
    before = shop.unseen_full.left(shop.fit([], shop.full, bend=False))
    assert _is_shown_unseen(shop, [], before) is is_shown
    assert _is_shown_unseen(shop, [], 0.5 * before)
