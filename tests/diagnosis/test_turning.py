"""A base that is not level: the torque of its tilt is worked out here in closed form."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis import finding
from oed.diagnosis.candidates import turning
from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.telling import foretells_most
from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence import naming
from oed.diagnosis.evidence.estimates import estimates, from_declared
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.tilt_review import tilt_fault
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.gravity import tilt_directions
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import widths_of, with_widths
from tests.diagnosis import arm
from tests.diagnosis.arm import COULOMB, INERTIA, VISCOUS, data_set, rigid
from tests.diagnosis.shop import shop_of, trial_of

RIVALS = ("gravity_direction", "joint_spring", "torque_offset", "torque_gain", "torque_ripple")
SETTINGS = DiagnosisSettings(surrogates=39, bootstrap=40, refined=4, candidates=RIVALS)
FIRST_LINK = 2.4  # [kg m] first moment of both links about the first axis, seen by no level arm


def weight_of(tilt):
    """Torque of both links on a base that is tilted about its y axis [rad]."""

    def weight(q, dq, ddq):
        _, x, y, _ = INERTIA
        both = q[:, 0] + q[:, 1]
        # Gravity pulls along the base's x axis as well: -g sin(tilt) times the rate of change of
        # each link's first moment along x.
        along = 9.81 * np.sin(tilt)
        elbow = along * (x * np.sin(both) + y * np.cos(both))
        return np.stack([along * FIRST_LINK * np.sin(q[:, 0]) + elbow, elbow], axis=1)

    return weight


def diagnosis_of(tilt, settings=SETTINGS):
    dataset = data_set(11, extra=weight_of(tilt))
    return diagnose(dataset, TorqueModel.standard(dataset.robot), settings)


@pytest.mark.parametrize("degrees", [3.0, 40.0])
def test_a_tilted_base_is_named_with_its_angle(degrees):
    tilt = np.deg2rad(degrees)
    found = diagnosis_of(tilt)
    assert [effect.name for effect in found.effects] == ["gravity_direction"]
    values = {p.name: p for p in found.effects[0].parameters}
    angle = np.hypot(values["tilt_1"].value, values["tilt_2"].value)
    assert angle == pytest.approx(tilt, rel=0.03)
    for name, truth in (("tilt_1", tilt), ("tilt_2", 0.0)):
        assert values[name].value == pytest.approx(truth, abs=4 * values[name].std)
    # Against the gravity that was declared, not against what the tables have been turned to.
    (effect,) = found.effects
    assert found.verdict == "explained"
    held = next(p for p in found.proof if p.role == "validation")
    gain = 1 - np.sqrt(np.mean((held.after / held.before) ** 2))
    assert effect.validation_gain == pytest.approx(gain, abs=0.02)
    assert all(rival.evidence > SETTINGS.decisive for rival in effect.rivals)
    test = next(p for p in found.proof if p.role == "test")
    assert test.after == pytest.approx(found.noise_floor, rel=0.1)


def test_a_tilt_of_less_than_a_milliradian_is_found_where_the_noise_shows_it(monkeypatch):
    monkeypatch.setattr(arm, "NOISE", arm.NOISE / 100)
    tilt = 7e-4
    found, _ = turning.turned_beside(shop_of(data_set(11, extra=weight_of(tilt))), [])
    angle = np.linalg.norm(turning.total_tilt(found, np.zeros(2)))
    # To within a step that the search takes no more.
    assert angle == pytest.approx(tilt, abs=1e-4)


def test_a_tilt_is_as_uncertain_as_draws_of_it_are_spread():
    """Drawn where the tables have turned to, and read off against the declared vertical."""
    shop, _ = turning.turned_beside(shop_of(data_set(11, extra=weight_of(np.deg2rad(40.0)))), [])
    trial = trial_of(shop, "gravity_direction", None)
    local = np.array([[4e-6, 1e-6], [1e-6, 1e-6]])
    _, covariance = from_declared(shop, trial, np.zeros(2), local)
    axes, size = tilt_directions(shop.baseline.model.robot.gravity)
    draws = np.random.default_rng(0).multivariate_normal(np.zeros(2), local, 20000)
    pulled = shop.baseline.model.robot.gravity / size + draws @ np.array(axes)
    sideways, down = pulled[:, :2], -pulled[:, 2]
    across = np.linalg.norm(sideways, axis=1, keepdims=True)
    angles = np.arctan2(across[:, 0], down)[:, None] * sideways / across
    own, _ = tilt_directions(shop.declared.model.robot.gravity)
    spread = np.cov(angles @ np.array(own)[:, :2].T, rowvar=False)
    # A variance of 20000 draws is known to 1 %, here to five times that.
    assert covariance == pytest.approx(spread, abs=0.05 * np.abs(spread).max())
    assert abs(covariance - local).max() > 0.3 * local.max()


def test_a_tilt_that_no_joint_feels_is_unknown():
    """What no column shows has no deviation of its own, such as a tilt about the axis of all joints."""
    shop = shop_of(data_set(11))
    trial = trial_of(shop, "gravity_direction", None)
    products = len(trial.effect.parameters) - 2
    variances = np.array([1e-6, 0.0, *products * [1e-4]])
    felt, unfelt = estimates(shop, trial, np.zeros(len(variances)), np.diag(variances))[:2]
    assert felt.std == pytest.approx(1e-3)
    assert unfelt.std > 1.5  # [rad], of any angle whatever


def test_a_tilt_is_found_beside_a_gain_that_multiplies_its_torque():
    tilt, gain = np.deg2rad(30.0), 0.4
    weight = weight_of(tilt)

    def extra(q, dq, ddq):
        whole = rigid(q, dq, ddq) + COULOMB * np.sign(dq) + VISCOUS * dq + weight(q, dq, ddq)
        return weight(q, dq, ddq) + gain * whole * np.array([0.0, 1.0])

    shop = shop_of(data_set(11, extra=extra))
    found, (own,) = turning.turned_beside(shop, [Accepted(trial_of(shop, "torque_gain", 1), 0.0)])
    angle = np.linalg.norm(turning.total_tilt(found, np.zeros(2)))
    assert angle == pytest.approx(tilt, rel=0.01)
    (coefficients,) = found.fit([own.trial]).coefficients
    assert coefficients[0] == pytest.approx(gain, rel=0.02)


def test_a_tilt_does_without_moments_that_cannot_be(monkeypatch):
    """Beside what else is missing they may take any size: of the tilt the other links tell."""
    tilt = np.deg2rad(3.0)
    shop = shop_of(data_set(11, extra=weight_of(tilt)))
    assert set(turning.turned(shop, ()).baseline.columns) > set(shop.baseline.columns)
    own = turning.moment_fault
    is_bare = lambda found: len(found.baseline.columns) == len(shop.baseline.columns)  # noqa: E731
    monkeypatch.setattr(
        turning, "moment_fault", lambda s, fit: own(s, fit) if is_bare(s) else "mx is impossible"
    )
    bare = turning.turned(shop, ())
    assert bare.is_turned
    assert is_bare(bare)


def test_a_tilt_that_the_tables_have_foretells_what_they_show_of_it():
    """Of the few milliradians that are left after the turn nothing could be said."""
    shop = shop_of(data_set(11, extra=weight_of(np.deg2rad(3.0))))
    found = turning.turned(shop, ())
    left = trial_of(found, "gravity_direction", None)
    assert foretells_most(found, (), left, ())
    level = turning.turned(shop_of(data_set(11)), ())
    assert not foretells_most(level, (), trial_of(level, "gravity_direction", None), ())


def test_a_tilt_stands_beside_a_name_whose_shape_is_hardly_known():
    """How a shape would bend is no part of what is foretold with it."""
    shop = shop_of(data_set(11, extra=weight_of(np.deg2rad(3.0))))
    found = turning.turned(shop, ())
    vague = trial_of(found, "nonlinear_viscous", 0, (0.5,))
    assert tilt_fault(found, [Accepted(vague, 10.0)]) is None


def test_a_search_begins_with_a_tilt_that_tells_more_than_a_name(monkeypatch):
    own = finding.search
    begun = []

    def hasty(shop, refused=(), *, instead_of=frozenset(), **others):
        begun.append(instead_of)
        if instead_of:
            return own(shop, refused, instead_of=instead_of, **others)
        trial = trial_of(shop, "joint_spring", 0)
        return shop, Selection.of(shop, [Accepted(trial, 100.0)], [])

    monkeypatch.setattr(finding, "search", hasty)
    found = diagnosis_of(np.deg2rad(3.0))
    assert begun == [frozenset(), frozenset({("joint_spring", 0)})]
    assert [e.name for e in found.effects] == ["gravity_direction"]


def test_a_tilt_that_proves_to_be_none_does_not_stay_in_the_model(monkeypatch):
    def doubt(_shop, whole):
        return next((t for t in whole.chosen if t.name == "gravity_direction"), None)

    monkeypatch.setattr(naming, "doubtful_name", doubt)
    names = ("gravity_direction", "joint_spring", "torque_offset")
    found = diagnosis_of(np.deg2rad(3.0), dataclasses.replace(SETTINGS, candidates=names))
    assert "gravity_direction" not in {effect.name for effect in found.effects}
    assert "gravity_direction" in {r.name for r in found.refused}
    declared = found.before.model.robot.gravity
    np.testing.assert_array_equal(found.after.model.robot.gravity, declared)
    assert not found.shop.is_turned


def test_a_tilt_that_test_recordings_contradict_is_taken_back():
    """They were made on a level base."""
    names = ("gravity_direction", "torque_gain")
    own, other = (data_set(11, extra=extra) for extra in (weight_of(np.deg2rad(10.0)), None))
    kept = tuple(
        level if level.role == "test" else tilted
        for tilted, level in zip(own.recordings, other.recordings, strict=True)
    )
    dataset = dataclasses.replace(own, recordings=kept)
    settings = dataclasses.replace(SETTINGS, candidates=names)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), settings)
    assert "gravity_direction" not in {effect.name for effect in found.effects}
    test = next(p for p in found.proof if p.role == "test")
    assert np.all(test.after <= 1.05 * test.before)
    # What it would have been with the tilt is said, too.
    assert found.unchecked is not None
    assert found.unchecked.max() > 2 * test.after.max()


def test_turned_and_level_tables_have_friction_that_turns_alike():
    """Else what a sign does would count for or against the tilt."""
    shop, _ = turning.turned_beside(shop_of(data_set(11, extra=weight_of(np.deg2rad(40.0)))), [])
    assert shop.is_turned
    slow = with_widths(shop.baseline.model, [0.2, 0.1])
    later = shop.on(dataclasses.replace(shop.baseline, model=slow))
    assert later.is_turned
    assert widths_of(later.upright.baseline.model) == [0.2, 0.1]
    assert not later.upright.is_turned
