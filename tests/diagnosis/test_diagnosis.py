"""Promises of a diagnosis as a whole, at a size that a test can pay."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence import unlocated
from oed.diagnosis.evidence.lack_of_fit import LackOfFit
from oed.diagnosis.evidence.withheld import Errors
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of

HUM = 2.347  # [Hz], no multiple of the motion's own frequency
EARLY = 2e-3  # [s], as a commanded torque comes before what it does
SEALED = ("validation", "test")
FAST = dataclasses.replace(DiagnosisSettings(), surrogates=39, bootstrap=40, refined=4)
# Without gears, loads and lags, whose columns are made anew at every step of their shapes.
QUICK = dataclasses.replace(
    FAST,
    candidates=(
        "stribeck",
        "nonlinear_viscous",
        "asymmetric_viscous",
        "torque_offset",
        "presliding_hysteresis",
        "load_dependent_friction",
        "position_dependent_friction",
        "torque_ripple",
        "joint_spring",
        "motor_coupling",
        "torque_gain",
        "encoder_eccentricity",
    ),
)


@cache
def diagnosis_of(kind, seed=0):
    cases = {
        "clean": {},
        "coloured": {"colour": 0.03},
        "steps": {"step": 1e-4},
        "slow": {"colour": 0.5, "repetitions": 1},
        "coarse": {"step": 2e-3, "repetitions": 1},
        "stribeck": {"extra": stribeck(1.0)},
        "foreign": {"extra": lambda q, dq, ddq: np.stack([q[:, 1] * dq[:, 0], 0 * q[:, 0]], 1)},
        "early": {"late": -EARLY},
        "hum": {"hum": lambda t, dq: np.outer(np.sin(2 * np.pi * HUM * t), [0.1, 0.0])},
        "brake": {"hum": _brake},
        "elusive": {"extra": _elusive},
        "stop": {"extra": _stop, "repetitions": 1, "near": 0.45},
        "strange": {"extra": _strange, "repetitions": 1, "roles": ("estimation",) * 5 + SEALED},
    }
    dataset = data_set(seed, **cases[kind])
    settings = QUICK if kind in ("strange", "elusive") else FAST
    return diagnose(dataset, TorqueModel.standard(dataset.robot), settings)


def _stop(q, dq, ddq):
    """Rubber that only the motions of the validation recordings reach."""
    return np.stack([-40.0 * np.maximum(q[:, 0] - 0.7, 0.0), 0 * q[:, 0]], axis=1)


def _elusive(q, dq, ddq):
    """Waves so fine that the paths of two motions do not determine them between."""
    return np.stack([2.0 * np.cos(14 * q[:, 0]) * np.sin(4 * q[:, 1]), 0 * q[:, 0]], axis=1)


def _brake(t, dq):
    """Drags on the second joint for some seconds, and then does not."""
    drags = np.sin(0.7 * t) + np.sin(1.63 * t + 1.0) > 0.2
    return np.stack([0 * t, 0.4 * drags * np.sign(dq[:, 1])], axis=1)


def _strange(q, dq, ddq):
    """Waves too fine for the term that notices them; drag that varies along the turn."""
    waves = 1.5 * np.cos(6 * q[:, 0]) * np.sin(1.5 * q[:, 1])
    return np.stack([waves, q[:, 1] * dq[:, 1]], axis=1)


@pytest.mark.parametrize("kind", ["clean", "coloured", "slow", "steps", "coarse"])
def test_nothing_is_named_where_nothing_is_missing(kind):
    found = diagnosis_of(kind)
    assert found.effects == ()
    assert found.verdict == "nothing found"


def test_lack_of_fit_is_not_seen_where_there_is_none():
    found = diagnosis_of("coloured")
    assert found.lack_before.ratio.max() < 1.2


def test_names_the_effect_and_its_joint_although_its_formula_differs():
    found = diagnosis_of("stribeck")
    assert [(e.name, e.joint) for e in found.effects] == [("stribeck", 0)]
    value = {p.name: p for p in found.effects[0].parameters}["Fs_1"]
    assert abs(value.value - 1.0) < max(3 * value.std, 0.2)
    assert found.lack_before.ratio[0] > 1.2


def test_error_reaches_the_floor_on_recordings_that_were_sealed():
    found = diagnosis_of("stribeck")
    test = next(p for p in found.proof if p.role == "test")
    assert test.after[0] < test.before[0]
    assert test.after[0] < 1.15 * found.noise_floor[0]


@pytest.mark.parametrize("kind", ["clean", "coloured", "steps", "stribeck", "foreign"])
def test_never_worse_on_validation(kind):
    found = diagnosis_of(kind)
    validation = next(p for p in found.proof if p.role == "validation")
    assert np.mean((validation.after / validation.before) ** 2) <= 1.0


def test_what_does_not_predict_is_said_and_kept_out_of_the_model():
    found = diagnosis_of("elusive")
    assert found.effects == ()
    assert any(u.joint == 0 and not u.stands_in for u in found.unexplained)
    validation = next(p for p in found.proof if p.role == "validation")
    assert np.all(validation.after <= 1.02 * validation.before)


def test_claims_no_name_for_what_the_catalogue_lacks():
    found = diagnosis_of("foreign")
    assert found.effects == ()
    assert found.verdict == "unexplained"
    assert any(u.joint == 0 and "q_2" in u.depends_on for u in found.unexplained)


def test_drag_that_varies_along_the_turn_is_not_taken_for_friction_that_does():
    found = diagnosis_of("strange")
    assert found.effects == ()
    assert [u.label for u in found.unexplained if u.joint == 1] == ["f(q_2) dq_2"]


@pytest.mark.parametrize(("kind", "joint"), [("foreign", 0), ("strange", 1)])
def test_a_coefficient_that_varies_stands_in_down_to_the_floor(kind, joint):
    found = diagnosis_of(kind)
    test = next(p for p in found.proof if p.role == "test")
    assert test.before[joint] > 1.5 * found.noise_floor[joint]
    assert test.after[joint] < 1.1 * found.noise_floor[joint]


def test_a_term_becomes_as_fine_as_what_it_follows():
    found = diagnosis_of("strange")
    term = next(u for u in found.unexplained if u.joint == 0)
    assert term.depends_on == ("q_1", "q_2")
    test = next(p for p in found.proof if p.role == "test")
    # Splines over a quarter of the range, which noticed it, cannot follow six waves a turn.
    assert test.before[0] > 5 * found.noise_floor[0]
    assert test.after[0] < 1.1 * found.noise_floor[0]


def test_says_that_something_keeps_its_own_time():
    found = diagnosis_of("hum")
    assert found.effects == ()
    assert found.verdict == "unexplained"
    (hum,) = found.unexplained
    assert (hum.joint, hum.depends_on, hum.stands_in) == (0, ("time",), False)
    amplitude, frequency = (float(hum.label.split()[k]) for k in (0, 3))
    # An amplitude's standard deviation is sqrt(2 S f_band / N), here about 0.004 N m.
    assert amplitude == pytest.approx(0.1, abs=0.015)
    assert frequency == pytest.approx(HUM, abs=1 / 60)


def test_says_that_something_is_there_which_the_validation_recordings_alone_show():
    found = diagnosis_of("stop")
    assert found.effects == ()
    assert found.verdict == "unexplained"
    assert 0 in {u.joint for u in found.unexplained}
    # The estimation recordings fit to the noise.
    assert np.all(found.lack_after.p_value > DiagnosisSettings().level)


def test_what_is_far_above_the_floor_is_said_though_noise_might_change_as_slowly(monkeypatch):
    monkeypatch.setattr(unlocated, "keeps_step", lambda *_: False)
    dataset = data_set(0, extra=lambda q, dq, ddq: [4.0, 0.0] * np.sin(3 * q), repetitions=1)
    model = TorqueModel.standard(dataset.robot)
    found = diagnose(dataset, model, dataclasses.replace(FAST, max_effects=0))
    proof = {p.role: p.after / found.noise_floor for p in found.proof}
    assert min(proof["estimation"][0], proof["validation"][0]) > unlocated.NO_FLOOR
    assert found.verdict == "unexplained"
    assert [(u.joint, u.depends_on) for u in found.unexplained] == [(0, ("time",))]


@pytest.mark.parametrize(("unseen", "of"), [(1.0, ("time",)), (3.0, ()), (0.0, ())])
def test_what_the_fitted_motions_alone_show_in_no_step_with_them_is_of_time(
    monkeypatch, unseen, of
):
    """A blow that the arm takes once; what others show too, or where there are none, is something."""
    monkeypatch.setattr(unlocated, "keeps_step", lambda *_: False)
    shop, level = shop_of(data_set(0, repetitions=1)), np.ones(2)
    errors = Errors(np.array([5.0, 1.0]), np.array([unseen, 1.0]), level, level, level)
    left = LackOfFit(errors.seen, np.array([0.0, 1.0]))
    found = list(unlocated.unlocated(shop, (), (), left, errors))
    assert [(u.joint, u.depends_on) for u in found] == [(0, of)]


def test_says_that_friction_comes_and_goes():
    found = diagnosis_of("brake")
    assert found.effects == ()
    assert found.verdict == "unexplained"
    (brake,) = found.unexplained
    assert (brake.joint, brake.depends_on, brake.stands_in) == (1, ("time", "dq_2"), False)


def test_augmented_model_is_an_ordinary_torque_model():
    found = diagnosis_of("stribeck")
    motion = found.shop.full.rows.prepared[0].motion[:50]
    torque = found.after.model.torque(found.after.parameters, motion)
    assert torque.shape == (50, 2)
    assert len(found.after.model.parameters) == len(found.after.parameters)


def test_a_joint_that_stands_still_is_named():
    dataset = data_set(0, repetitions=1)
    still = tuple(
        dataclasses.replace(r, q=r.q * [1.0, 0.0] + [0.0, 0.3]) for r in dataset.recordings
    )
    dataset = dataclasses.replace(dataset, recordings=still)
    with pytest.raises(
        OedError, match=r"joint 'joint_2' moves by no more than 0 rad .* \[fixed\] of dataset.toml"
    ):
        diagnose(dataset, TorqueModel.standard(dataset.robot), QUICK)


def test_a_torque_that_comes_first_is_a_delay_below_zero():
    found = diagnosis_of("early")
    assert [(e.name, e.joint) for e in found.effects] == [("time_delay", None)]
    (delay,) = found.effects[0].parameters
    assert abs(delay.value + EARLY) < 3 * delay.std < EARLY
    assert found.verdict == "explained"


def test_what_the_test_recording_contradicts_is_said_and_kept_out_of_the_model():
    def foreign(q, dq, ddq):
        return np.stack([q[:, 1] * dq[:, 0], 0 * q[:, 0]], axis=1)

    shown, rid_of_it = data_set(3, extra=foreign), data_set(3)
    dataset = dataclasses.replace(
        shown, recordings=(*shown.recordings[:-1], rid_of_it.recordings[-1])
    )
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), QUICK)
    assert any(u.joint == 0 and not u.stands_in for u in found.unexplained)
    proof = {p.role: p for p in found.proof}
    assert proof["test"].after == pytest.approx(proof["test"].before)
    assert found.verdict == "unexplained"
