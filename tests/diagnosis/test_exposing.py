"""The motion that tells most of what is in doubt."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.rivals.exposing import design_exposing
from oed.diagnosis.rivals.motions import random_motions
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

SPEED = 0.1  # [rad/s]


def _slow(motion, joint=0):
    """Share of the time at speeds at which the friction falls."""
    return float(np.mean(np.abs(motion.dq[:, joint]) < 2 * SPEED))


def test_friction_that_falls_at_low_speed_asks_for_a_slow_motion():
    shop = shop_of(data_set(3, extra=stribeck(0.4, SPEED)), candidates=("stribeck",))
    found = design_exposing(shop, [], np.random.default_rng(1), candidates=18)
    assert found is not None
    assert found.doubted[0].key == ("stribeck", 0)
    assert found.gain > 1
    motions, _ = random_motions(
        shop.baseline.model.robot, shop.mean.rows.prepared[0], np.random.default_rng(1), 18
    )
    assert _slow(found.motion) > np.median([_slow(motion) for motion in motions])


def test_what_was_found_is_not_in_doubt():
    shop = shop_of(data_set(3, extra=stribeck(0.4, SPEED)), candidates=("stribeck",))
    chosen = [trial_of(shop, "stribeck", joint, (SPEED, 2.0, 1.0)) for joint in range(2)]
    assert design_exposing(shop, chosen, np.random.default_rng(1), candidates=2) is None


def test_what_is_part_of_the_model_without_a_name_is_not_in_doubt():
    """Nor is it forgotten where rivals are compared."""
    dataset = data_set(3, extra=stribeck(1.5, SPEED))
    settings = DiagnosisSettings(surrogates=19, bootstrap=20, refined=4, candidates=("stribeck",))
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    (law,) = found.standing
    assert law.key == ("stribeck", 0)
    nameless = dataclasses.replace(found, effects=())
    assert nameless.rival_pairs() == []
    rng = np.random.default_rng(1)
    exposing = design_exposing(found.shop, nameless.standing, rng, candidates=2)
    assert exposing is None or law.key not in {t.key for t in exposing.doubted}


def test_there_must_be_a_motion_to_choose():
    shop = shop_of(data_set(3, extra=stribeck(0.4, SPEED)), candidates=("stribeck",))
    with pytest.raises(ValueError, match="nothing to choose from"):
        design_exposing(shop, [], np.random.default_rng(1), candidates=0)
