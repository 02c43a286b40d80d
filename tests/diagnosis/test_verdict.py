"""What is left, of no term that was tried: said for a joint, or small enough to pass."""

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.evidence.at_its_end import is_at_its_end
from oed.diagnosis.evidence.caveats import caveats
from oed.diagnosis.evidence.contenders import Rival, find_rivals
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.lack_of_fit import LackOfFit, foretold_error
from oed.diagnosis.evidence.unlocated import describe_unlocated
from oed.diagnosis.evidence.verdict import (
    FoundEffect,
    Unexplained,
    decide,
    outdone,
    preferred_rival,
)
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis_new.noise.linear_fit import project
from oed.dynamics.effects.catalogue import CATALOGUE
from tests.diagnosis.arm import COULOMB, VISCOUS, data_set, rigid
from tests.diagnosis.shop import shop_of, trial_of

SETTINGS = DiagnosisSettings()
SURE = 1e-9  # chance of a lack of fit that no one doubts


def left_over(p_value, seen, unseen, located=()):
    left = LackOfFit(np.array([3.0, 1.0]), np.array([p_value, 0.5]))
    return describe_unlocated(
        located, left, np.array([seen, 1.0]), np.array([unseen, 1.0]), SETTINGS
    )


def test_what_only_the_mean_of_many_repetitions_shows_is_small_beside_the_noise():
    found = left_over(SURE, seen=1.1, unseen=1.2)
    assert found == ()
    assert decide((), found) == "nothing found"


def test_an_error_without_significance_is_a_floor_that_was_read_too_low():
    assert left_over(0.3, seen=1.6, unseen=1.6) == ()


@pytest.mark.parametrize(("p_value", "seen", "unseen"), [(SURE, 1.5, 1.0), (0.3, 1.0, 2.5)])
def test_a_clear_error_is_said_with_its_joint(p_value, seen, unseen):
    (found,) = left_over(p_value, seen, unseen)
    assert (found.joint, found.depends_on) == (0, ())
    # Squares over those of the floor: what is not noise.
    assert found.share == pytest.approx(1 - 1 / max(seen, unseen) ** 2)
    assert decide((), (found,)) == "unexplained"


def test_error_of_another_motion_is_foretold_from_noise_alone():
    """Against errors in N m of models fitted to many draws of noise as slow as the motion."""
    rng = np.random.default_rng(4)
    together, inertia, deviation = 30, 0.3, 0.2

    def slow(*sizes):
        return np.repeat(rng.normal(size=sizes), together, axis=-1)

    # The motion that is foretold asks for far more than the one that was fitted.
    seen, other, noise = slow(50), 10 * slow(50), deviation * slow(2000, 50)
    found = inertia + noise @ seen / (seen @ seen)
    errors = (found[:, None] - inertia) * other + deviation * slow(2000, 50)
    expected = np.sqrt(np.mean(errors**2)) / deviation
    assert expected > 1.5
    white = [x[None, :, None] / deviation / np.sqrt(together) for x in (seen, other)]
    inverse, counted = project(white[0]).inverse, np.full(1, len(other) / together)
    assert foretold_error(inverse, white[1], counted) == pytest.approx([expected], rel=0.05)


def test_a_joint_that_a_term_names_is_not_named_again():
    term = Unexplained(0, ("q_1",), 0.5, "f(q_1)", stands_in=False)
    assert left_over(SURE, seen=2.0, unseen=3.0, located=(term,)) == ()


def _effect(rival_name, evidence, *, contender=True):
    """A coupling with one rival."""
    shop = shop_of(data_set(1, repetitions=1), held=False)
    coupling = next(t for t in shop.physical if t.key == ("motor_coupling", (1, 0)))
    other = next(t for t in shop.physical if t.key == (rival_name, 1))
    rival = Rival(rival_name, 1, evidence, other, contender, SETTINGS.decisive)
    return FoundEffect("motor_coupling", 1, (), 1e-9, 0.2, (rival,), coupling)


@pytest.mark.parametrize(
    ("name", "evidence", "contender", "gives_way"),
    [
        ("rotor_inertia", -20.0, True, True),
        ("rotor_inertia", -2.0, True, False),  # too close to call
        ("rotor_inertia", -20.0, False, False),  # fell at a test
        ("stribeck", -20.0, True, False),  # no plainer
    ],
)
def test_a_name_gives_way_to_a_plainer_one_that_says_far_more(name, evidence, contender, gives_way):
    effect = _effect(name, evidence, contender=contender)
    found = preferred_rival([effect], SETTINGS.decisive, set())
    assert (found is not None) is gives_way
    if found is not None:
        assert found == (effect.trial, effect.rivals[0].trial)
        # What gave way once does not come back.
        assert preferred_rival([effect], SETTINGS.decisive, {found[1].key}) is None


@pytest.mark.parametrize(
    ("name", "evidence", "gives_way"),
    [
        ("stribeck", -20.0, True),
        ("stribeck", -4.0, True),
        ("stribeck", -2.0, False),  # as good as equal
        ("torque_ripple", -20.0, False),  # another kind: it may be something else that is there
    ],
)
def test_a_name_gives_way_to_one_of_its_kind_that_says_more(name, evidence, gives_way):
    """With as many parameters: these are paid for in what it says."""
    shop = shop_of(data_set(1, repetitions=1), held=False)
    own, other = trial_of(shop, "nonlinear_viscous", 1), trial_of(shop, name, 1)
    rival = Rival(name, 1, evidence, other, True, SETTINGS.decisive)
    effect = FoundEffect(own.name, 1, (), 1e-9, 0.2, (rival,), own)
    found = preferred_rival([effect], SETTINGS.decisive, ())
    assert found == ((own, other) if gives_way else None)


def test_a_gain_is_weighed_against_that_of_the_other_joint():
    """Of an arm of two joints no data tell them apart: the other is told, and no experiment asked."""

    def louder(q, dq, ddq):
        whole = rigid(q, dq, ddq) + COULOMB * np.sign(dq) + VISCOUS * dq
        return 0.1 * whole * [0.0, 1.0]

    shop = shop_of(data_set(3, extra=louder))
    for joint in (0, 1):
        own = trial_of(shop, "torque_gain", joint)
        rivals = find_rivals(shop, Accepted(own, 1e3), [])
        (other,) = (r for r in rivals if r.name == "torque_gain")
        assert other.joint == 1 - joint
        # The first is worth what the other is, but for what a gain of 10 % is to second order.
        assert abs(other.evidence) < SETTINGS.decisive
        assert not other.contender
        assert other.is_same
        assert not any(r.is_same for r in rivals if r is not other)
        effect = FoundEffect("torque_gain", joint, (), 1e-9, 0.2, rivals, own)
        (note,) = caveats([effect], [], shop.baseline.model.robot)
        assert "which of the two joints it is" in note
        assert all(r.evidence > SETTINGS.decisive for r in rivals if r is not other)


@pytest.mark.parametrize(("evidence", "gives_way"), [(-2.0, True), (4.0, True), (20.0, False)])
def test_a_name_at_its_end_gives_way_to_any_rival_within_the_evidence(evidence, gives_way):
    effect = _effect("stribeck", evidence, contender=evidence < SETTINGS.decisive)
    found = preferred_rival([effect], SETTINGS.decisive, (), {effect.trial.key})
    assert (found is not None) is gives_way
    assert preferred_rival([effect], SETTINGS.decisive, ()) is None


@pytest.mark.parametrize(
    ("first", "ratio", "evidence", "gives_way"),
    [
        ((1, 0), 0.0, 1.0, True),
        ((1, 0), 0.0, 20.0, False),  # friction tells which of the two it is
        ((0, 1), 0.0, 1.0, False),
        # One motor that may be either's: the outer joint's.
        ((1, 0), -1.0, 1.0, False),
        ((0, 1), -0.9, 1.0, True),
        ((0, 1), -0.5, 1.0, True),
        ((0, 1), -0.5, 20.0, False),  # the ratio tells whose it is
    ],
)
def test_a_coupling_that_is_the_same_from_either_joint_has_one_name(
    first, ratio, evidence, gives_way
):
    shop = shop_of(data_set(1, repetitions=1), held=False)
    own, mirror = (
        trial_of(shop, "motor_coupling", target, (ratio, 2.0)) for target in (first, first[::-1])
    )
    rival = Rival("motor_coupling", mirror.joint, evidence, mirror, False, SETTINGS.decisive)
    effect = FoundEffect("motor_coupling", own.joint, (), 1e-9, 0.2, (rival,), own)
    found = preferred_rival([effect], SETTINGS.decisive, ())
    assert found == ((own, mirror) if gives_way else None)


@pytest.mark.parametrize(
    ("distance", "std", "ended"),
    [
        (0.08, 1e-3, True),
        (0.0799, 1e-3, True),
        (0.02, 1e-3, False),
        (0.08, 0.3, False),
        (3e-4, 1e-5, False),  # a narrower loop is one of presliding still
    ],
)
def test_a_loop_as_wide_as_presliding_gets_is_at_its_end(distance, std, ended):
    shop = shop_of(data_set(1, repetitions=1), held=False)
    trial = trial_of(shop, "presliding_hysteresis", 0, (distance, 0.7))
    parameters = (Estimated("Fh_1", 1.0, 0.1, "N m"), Estimated("distance", distance, std, "rad"))
    effect = FoundEffect(trial.name, 0, parameters, 1e-9, 0.2, (), trial)
    assert is_at_its_end(shop, effect) is ended


@pytest.mark.parametrize(
    ("above", "overtone", "ended"),
    [(0.0, 0.0, True), (0.1, 0.2, True), (0.1, 0.5, False), (0.5, 0.0, False)],
)
def test_a_ripple_of_the_longest_waves_is_at_its_end(above, overtone, ended):
    """To its deviation, 0.2 periods a turn: fewer are any function of position."""
    shop = shop_of(data_set(1, repetitions=1), held=False)
    shape, _ = CATALOGUE["torque_ripple"].shapes_for(shop.context, 0)
    harmonic = shape.lower + above
    trial = trial_of(shop, "torque_ripple", 0, (harmonic, 2.0))
    sizes = (1.0, 0.0, 0.0, overtone)
    waves = (Estimated(f"wave_{k}", size, 0.01, "N m") for k, size in enumerate(sizes))
    parameters = (*waves, Estimated("harmonic", harmonic, 0.2, "1/turn"))
    effect = FoundEffect(trial.name, 0, parameters, 1e-9, 0.2, (), trial)
    assert is_at_its_end(shop, effect) is ended


@pytest.mark.parametrize(
    ("name", "evidence", "contender", "is_outdone"),
    [
        ("stribeck", -20.0, True, True),
        ("stribeck", -2.0, True, False),  # too close to call
        ("stribeck", -20.0, False, False),  # fell at a test
        ("rotor_inertia", -20.0, True, False),  # of its kind: it gives way instead
    ],
)
def test_a_name_that_another_outdoes_is_not_what_is_there(name, evidence, contender, is_outdone):
    effect = _effect(name, evidence, contender=contender)
    found = outdone([effect], SETTINGS.decisive)
    assert found is (effect.trial if is_outdone else None)
