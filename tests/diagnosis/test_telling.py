"""What decides between two names: what they explain, and what they foretell."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.telling import foretells_most, most_telling_first, telling
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence.contenders import find_rivals
from oed.diagnosis.search.selection import search
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.terms.scores import inflation_of, score
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import widths_of
from tests.diagnosis.arm import COULOMB, RATE, data_set
from tests.diagnosis.shop import shop_of

OFFSET = 0.8  # [N m] in every recording
RIPPLE, HARMONIC = 1.5, 5.0  # [N m] in those that are fitted alone, and waves a turn
SPRING = 1.0  # [N m/rad]
WAVES = 2.0  # [N m] that no effect of one joint follows
LATE = 4  # samples by which a torque comes late
TURN = 0.04  # [rad/s] over which dry friction turns


def pulled(*, ripple=0.0, stiffness=0.0):
    def torque(q, dq, ddq):
        along = stiffness * q[:, 0] + ripple * np.cos(HARMONIC * q[:, 0])
        return np.stack([OFFSET + along, np.zeros(len(q))], axis=1)

    return torque


@pytest.fixture(scope="module")
def accident():
    """A ripple that is there only while the fitted motions run, beside an offset that stays."""
    fitted, held = data_set(5, extra=pulled(ripple=RIPPLE)), data_set(5, extra=pulled())
    recordings = tuple(
        a if a.role == "estimation" else b
        for a, b in zip(fitted.recordings, held.recordings, strict=True)
    )
    return dataclasses.replace(fitted, recordings=recordings)


def of_first_joint(shop, name):
    fit = shop.before.fit
    trials = [t for t in shop.physical if t.key == (name, 0)]
    return max((score(t, fit) for t in trials), key=lambda s: s.gain)


def test_what_does_not_come_again_tells_less(accident):
    shop = shop_of(accident)
    ripple, offset = (of_first_joint(shop, name) for name in ("torque_ripple", "torque_offset"))
    assert ripple.gain > offset.gain
    (here, there), _ = telling(shop, (), [ripple, offset])
    assert there > here
    assert foretells_most(shop, (), offset.trial, [])
    assert not foretells_most(shop, (), ripple.trial, [])


def test_without_validation_what_is_explained_decides(accident):
    own = tuple(r for r in accident.recordings if r.role == "estimation")
    shop = shop_of(dataclasses.replace(accident, recordings=own))
    ripple, offset = (of_first_joint(shop, name) for name in ("torque_ripple", "torque_offset"))
    (here, there), _ = telling(shop, (), [ripple, offset])
    assert here > there
    assert not foretells_most(shop, (), offset.trial, [])


def test_the_true_one_of_many_comes_first():
    shop = shop_of(data_set(5, extra=pulled(stiffness=SPRING)))
    offset = next(t for t in shop.physical if t.key == ("torque_offset", 0))
    order = most_telling_first(shop, ranked(shop, shop.physical, [offset], 6), [offset])
    assert order[0].trial.key == ("joint_spring", 0)


def turned_by_both(q, dq, ddq):
    """Friction of a motor that turns with both joints, beside much that neither has a part in."""
    speed = dq[:, 0] + dq[:, 1]
    friction = 1.0 * np.sign(speed) + 0.5 * speed
    return np.stack([friction, friction + WAVES * np.cos(9 * q[:, 0] + 4 * q[:, 1])], axis=1)


def test_what_is_missing_besides_ties_no_two_of_a_kind():
    """Ratios of both joints' motor meet at one; the joint that it is nearer to must be told."""
    shop = shop_of(data_set(5, extra=turned_by_both))
    pool = [t for t in shop.physical if t.name == "motor_coupling"]
    order = most_telling_first(shop, ranked(shop, pool, (), 6), ())
    assert order[0].trial.target == (1, 0)
    assert order[0].trial.values[0] == pytest.approx(1.0, abs=0.05)
    assert inflation_of(shop.fit([order[0].trial]).fit).max() > 5


def turning(q, dq, ddq):
    """Dry friction that turns over a few hundredths of a radian a second, not at once."""
    return COULOMB * (np.tanh(dq / TURN) - np.sign(dq))


def test_how_fast_a_late_sign_turns_is_read_off_late_columns():
    """Beside a delay of columns that are not late, the sharpest sign would fit best."""
    dataset = data_set(7, extra=turning, repetitions=6)
    # The motion is periodic, so that the torque wraps.
    recordings = tuple(
        dataclasses.replace(r, tau=np.roll(r.tau, LATE, axis=0)) for r in dataset.recordings
    )
    late = dataclasses.replace(dataset, recordings=recordings)
    shop, selection = search(shop_of(late, candidates=("time_delay", "filter_lag")))
    (found,) = selection.accepted
    assert found.trial.name == "time_delay"
    # The noise of the torque leaves a tenth of a millisecond, and a tenth of the width.
    assert found.trial.values[0] == pytest.approx(LATE / RATE, abs=2e-4)
    assert widths_of(shop.baseline.model) == pytest.approx([TURN, TURN], rel=0.2)


def test_what_holds_the_named_effect_is_no_rival_of_it():
    """A spring whose stiffness is free fits an offset as well, on any motion."""
    shop = shop_of(data_set(5, extra=pulled()))
    offset = next(t for t in shop.physical if t.key == ("torque_offset", 0))
    rivals = {(r.name, r.joint): r for r in find_rivals(shop, Accepted(offset, 1.0), [])}
    spring = rivals["joint_spring", 0]
    assert spring.evidence < 20  # the price of its stiffness, and not much more
    assert not spring.contender


def through_lag(tau, time_constant):
    """A periodic torque behind a lag of the first order."""
    frequency = np.fft.rfftfreq(len(tau), 1 / RATE)
    lag = 1 / (1 + 2j * np.pi * frequency * time_constant)
    return np.fft.irfft(lag[:, None] * np.fft.rfft(tau, axis=0), len(tau), axis=0)


@pytest.mark.parametrize("name", ["time_delay", "filter_lag"])
def test_a_lag_is_told_from_a_delay_of_its_time_constant(name):
    dataset = data_set(7, repetitions=6)
    recordings = tuple(
        dataclasses.replace(
            r,
            tau=np.roll(r.tau, LATE, axis=0)
            if name == "time_delay"
            else through_lag(r.tau, LATE / RATE),
        )
        for r in dataset.recordings
    )
    late = dataclasses.replace(dataset, recordings=recordings)
    settings = DiagnosisSettings(
        surrogates=39, bootstrap=40, candidates=("time_delay", "filter_lag")
    )
    (found,) = diagnose(late, TorqueModel.standard(late.robot), settings).effects
    assert found.name == name
    assert found.parameters[0].value == pytest.approx(LATE / RATE, rel=0.05)
