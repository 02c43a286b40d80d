"""A load that every recording takes up at a moment of its own."""

from itertools import count

import numpy as np
import pytest

from oed.diagnosis.candidates.pickups import _best_stretch, _is_shown_unseen
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence.final_model import final_with
from oed.diagnosis.evidence.taken_up import with_moments_of
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.payload import PickUp
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import LENGTH, PERIOD, RATE, data_set, rigid
from tests.diagnosis.shop import shop_of, trial_of

MASS, REACH = 1.5, 0.25  # [kg], [m] from the second joint
SETTINGS = DiagnosisSettings(
    surrogates=39, bootstrap=40, candidates=("payload_change", "thermal_drift", "joint_spring")
)


def load_from(moments, releases=(), mass=MASS):
    """Torque of a point mass on the second link, in each recording from its moment on.

    Until its release, where there are any.
    """
    numbers = count()

    def torque(q, dq, ddq):
        t = np.arange(len(q)) / RATE
        own, number = (mass * LENGTH**2, mass * REACH, 0.0, mass * REACH**2), next(numbers)
        held = (t >= moments[number]) & (t < (releases[number] if len(releases) else np.inf))
        return held[:, None] * rigid(q, dq, ddq, own)

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


@pytest.mark.parametrize("repetitions", [1, 3])
def test_a_load_that_is_put_down_again_is_found_with_its_time(repetitions):
    whole = repetitions * PERIOD
    moments, releases = np.array([[0.35, 0.5, 0.2], [0.7, np.inf, 0.65]]) * whole
    dataset = data_set(
        5,
        extra=load_from(moments, releases),
        roles=("estimation", "validation", "test"),
        repetitions=repetitions,
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    (effect,) = found.effects
    assert effect.name == "payload_change"
    values = {p.name: p.value for p in effect.parameters}
    assert values["load_mx_2"] == pytest.approx(MASS * REACH, rel=0.05)
    assert values["moment"] == pytest.approx(moments[0], abs=0.1)
    assert values["held"] == pytest.approx(releases[0] - moments[0], abs=0.15)
    read = {name: own.value for name, own in found.moments.items()}
    expected = {"validation_1": 0.5, "test_2": 0.2, "test_2, put down": 0.65}
    assert read == {name: pytest.approx(x * whole, abs=0.1) for name, x in expected.items()}
    # A floor that is not read off repetitions is itself uncertain by some tenths.
    most = 1.2 if repetitions > 1 else SETTINGS.floor_ratio
    for proof in found.proof:
        assert np.all(proof.after < most * found.noise_floor), proof.role


def test_the_best_stretch_is_that_of_all_pairs_of_ends():
    rng = np.random.default_rng(3)
    for _ in range(50):
        gains = rng.normal(size=12)
        first, last = _best_stretch(gains)
        sums = [gains[a : b + 1].sum() for a in range(12) for b in range(a, 12)]
        assert gains[first : last + 1].sum() == pytest.approx(max(sums))


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


def test_a_moment_is_not_read_off_what_a_shape_would_be_if_it_were_another():
    """Beside a friction that is hardly there, what its derivative takes in a fit is any amount."""
    dataset = data_set(5, extra=load_from((13.0, 0.0, 0.0, 0.0)))
    shop = shop_of(dataset)
    load = trial_of(shop, "payload_change", None, (13.0,))
    friction = trial_of(shop, "nonlinear_viscous", 1, (3.0,))
    found = shop.fit([load, friction])
    test = [p for p in prepare(dataset.recordings) if p.role == "test"]
    _, moments = with_moments_of(shop, found, final_with(shop, found), test)
    (own,) = moments.values()
    # There all the time: the arm's first second hardly shows it, and noise has its share beside that.
    assert own.std < 0.5
    assert own.value < 1.0 + 2 * own.std
