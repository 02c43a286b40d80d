import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects import State
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.newton_euler import inverse_dynamics
from oed.errors import OedError
from oed.experiment.read_dataset import read_dataset
from oed.robot.builtin import imi_scara
from studies.bench.arm import PERIOD, Transmission, _with_spring_joint, least_inertia
from studies.bench.case import Case
from studies.bench.drive_forms import _low_pass, late_torque
from studies.bench.excitation import random_fourier_motion
from studies.bench.forms import FORMS, OUTSIDE, forms_of
from studies.bench.laboratory import LEAD_IN, Noise, build_laboratory
from studies.bench.make_dataset import make_dataset
from studies.bench.plan import GROUPS, plan
from studies.bench.robots import ROBOTS
from studies.bench.truth import Truth
from studies.bench.warmth import MILD


@pytest.fixture
def short(monkeypatch):
    """The two-joint arms with motions of a few seconds."""
    for key in ("scara", "vertical"):
        brief = dataclasses.replace(ROBOTS[key], period=3.0, repetitions=2, single=4.0, highest=1.5)
        monkeypatch.setitem(ROBOTS, key, brief)


def scara_arm(seed=0):
    bench = ROBOTS["scara"]
    arm = bench.arm(imi_scara(), np.random.default_rng(seed))
    return dataclasses.replace(arm, peak=(25.0, 4.0))


def test_every_name_of_the_catalogue_can_be_hidden():
    assert {form.name for form in FORMS.values()} == {*CATALOGUE, OUTSIDE}
    assert {form.name for form in FORMS.values() if form.kind == "plain"} == {*CATALOGUE}


def test_all_cases_are_told_apart():
    cases = plan(6)
    assert len({case.label for case in cases}) == len({case.key for case in cases}) == len(cases)
    assert {case.group for case in cases} == set(GROUPS)
    assert not any({"loose_gear", "elastic"} <= set(case.hidden) for case in cases)


def test_an_unknown_arm_or_form_is_refused():
    with pytest.raises(ValueError, match="no arm"):
        Case("clean", "crane", (), 1.0, "white", True, 0)
    with pytest.raises(ValueError, match="no forms"):
        Case("clean", "scara", ("gremlin",), 1.0, "white", True, 0)
    with pytest.raises(ValueError, match="no groups"):
        plan(1, ("lost",))


@pytest.mark.parametrize("key", sorted(FORMS))
def test_each_form_changes_the_arm_and_can_be_simulated(key):
    form, arm = FORMS[key], scara_arm()
    changed = form.inject(arm, form.first_joint, 1.0, np.random.default_rng(1)).arm
    assert changed is not arm
    acceleration = changed.plant().acceleration()
    rng = np.random.default_rng(2)
    values = [0.1 * rng.standard_normal(acceleration.size1_in(i)) for i in range(5)]
    assert np.isfinite(np.array(acceleration(*values))).all()


@pytest.mark.parametrize("noise", ["white", "felt"])
def test_a_clean_arm_is_explained_by_the_standard_model_whatever_the_noise(short, tmp_path, noise):
    truth = make_dataset(Case("clean", "scara", (), 1.0, noise, True, 3), tmp_path / "data")
    assert truth.size_in_noise < 0.005


def test_a_ripple_leaves_its_own_size(short, tmp_path):
    case = Case("single", "vertical", ("ripple",), 1.0, "white", False, 3)
    truth = make_dataset(case, tmp_path / "data")
    (hidden,) = truth.hidden
    wave, unit = hidden.parameters["wave"]
    assert hidden.joint is not None
    share = truth.excess[hidden.joint] / (wave / np.sqrt(2))
    assert unit == "N m"
    assert 0.7 < share < 1.1


def test_each_of_a_pair_has_its_size_by_itself(short, tmp_path):
    case = Case("pair", "scara", ("ripple", "eccentric_encoder"), 1.0, "coloured", False, 3)
    truth = make_dataset(case, tmp_path / "data")
    (wave, _), joint = truth.hidden[0].parameters["wave"], truth.hidden[0].joint
    ripple, eccentric = truth.alone
    assert joint is not None
    assert 0.6 < ripple[joint] / (wave / np.sqrt(2)) < 1.1
    # The torque of a reading that errs by a few thousandths is lost in noise.
    assert max(eccentric) < 0.1 * ripple[joint]
    assert truth.smaller_in_noise < 0.1 < truth.size_in_noise
    assert Truth.read(_written(truth, tmp_path)) == truth


def test_alone_an_effect_goes_by_the_clock_of_the_whole_session(short, tmp_path, monkeypatch):
    monkeypatch.setattr("studies.bench.make_dataset.COLD_SHARE", 0.0)
    case = Case("pair", "scara", ("cooling_start", "eccentric_encoder"), 1.0, "white", True, 3)
    truth = make_dataset(case, tmp_path / "data")
    joint, drift = truth.hidden[0].joint, truth.alone[0]
    assert joint is not None
    # The encoder's torque is a few hundredths of the drift's.
    np.testing.assert_allclose(drift[joint], truth.excess[joint], rtol=0.1)


def test_a_thermometer_shows_the_warmth_that_friction_feels(short, tmp_path, monkeypatch):
    monkeypatch.setattr("studies.bench.make_dataset.COLD_SHARE", 0.0)
    case = Case("single", "scara", ("swinging_warmth",), 1.0, "white", False, 3)
    (hidden,) = make_dataset(case, tmp_path / "data").hidden
    arm, joint = scara_arm(), hidden.joint
    assert joint is not None
    injected = FORMS["swinging_warmth"].inject(arm, joint, 1.0, np.random.default_rng(1))
    assert injected.arm.temperature is not None
    t = np.linspace(0.0, 200.0, 50)
    (torque,) = injected.arm.extra
    speed = np.ones_like(t)
    state = State(t, [speed, speed], [speed, speed], [speed, speed])
    felt = torque(state, [0.0, 0.0])[joint]
    # Alike at every instant: so much friction is lost for each kelvin.
    warmer = injected.arm.temperature(t)[:, joint] - MILD
    slope = injected.in_catalogue["warming_Fv_*"] + injected.in_catalogue["warming_Fc_*"]
    np.testing.assert_allclose(felt, slope * warmer, rtol=1e-9)
    recordings = read_dataset(tmp_path / "data").recordings
    first, second = (r.temperature for r in recordings[:2])
    assert first is not None
    assert second is not None
    assert np.ptp(first[:, 1 - joint]) == 0
    # The arm's clock runs on.
    assert not np.allclose(first[:, joint], second[:, joint])


def test_thermometers_tell_nothing_by_being_there(short, tmp_path):
    seen = []
    for seed in range(6):
        case = Case("clean", "scara", (), 1.0, "white", False, seed)
        make_dataset(case, tmp_path / str(seed))
        temperatures = [r.temperature for r in read_dataset(tmp_path / str(seed)).recordings]
        assert len({t is None for t in temperatures}) == 1
        seen.append(temperatures[0] is not None)
    assert {True, False} == set(seen)


def _written(truth, folder):
    truth.write(folder / "truth.json")
    return folder / "truth.json"


def test_the_data_set_keeps_its_limits_and_says_nothing_of_what_is_hidden(short, tmp_path):
    case = Case("single", "scara", ("stribeck",), 1.0, "coloured", True, 5)
    make_dataset(case, tmp_path / "data")
    dataset = read_dataset(tmp_path / "data")
    roles = [recording.role for recording in dataset.recordings]
    assert roles == ["estimation", "estimation", "validation", "test"]
    for recording in dataset.recordings:
        assert recording.repetitions == 2
        lower, upper = dataset.robot.limits.position.T
        assert np.all((recording.q > lower) & (recording.q < upper))
    words = (tmp_path / "data" / "dataset.toml").read_text(encoding="utf-8")
    names = [case.label, *(file.name for file in (tmp_path / "data").iterdir())]
    for word in ("stribeck", "friction", "truth", case.group, "coloured"):
        assert word not in words
        assert not any(word in name for name in names)


def test_the_same_case_gives_the_same_data(short, tmp_path):
    case = Case("single", "scara", ("dahl",), 1.0, "felt", False, 1)
    for name in ("a", "b"):
        make_dataset(case, tmp_path / name)
    a, b = (read_dataset(tmp_path / name).recordings[2] for name in ("a", "b"))
    np.testing.assert_array_equal(a.tau, b.tau)
    np.testing.assert_array_equal(a.q, b.q)


def test_repetitions_differ_by_noise_alone_that_is_as_stated(short, tmp_path):
    make_dataset(Case("clean", "scara", (), 1.0, "white", True, 8), tmp_path / "data")
    recording = read_dataset(tmp_path / "data").recordings[0]
    q, tau = (x.reshape(2, -1, 2) for x in (recording.q, recording.tau))
    spread = (tau[0] - tau[1]).std(axis=0) / np.sqrt(2)
    np.testing.assert_allclose(spread, ROBOTS["scara"].noise, rtol=0.12)
    # The encoder's error does not repeat either, or it would pass for torque.
    assert np.all(np.mean(q[0] != q[1], axis=0) > 0.3)
    assert np.abs(q[0] - q[1]).max() < 1.5e-4


@pytest.mark.parametrize("kind", ["white", "coloured"])
def test_the_noise_has_the_stated_variance(kind):
    rng = np.random.default_rng(0)
    noise = Noise.draw(kind, (0.5, 0.1), rng)
    drawn = np.sum([part.sample(200_000, 4, PERIOD, rng) for part in noise.signal], axis=0)
    np.testing.assert_allclose(drawn.std(axis=(0, 2)), (0.5, 0.1), rtol=0.06)


def test_a_motion_keeps_and_uses_its_limits():
    limits = imi_scara().limits
    motion = random_fourier_motion(limits, 10.0, 0.7, PERIOD, np.random.default_rng(4))
    for kind, values in (("position", motion.q), ("velocity", motion.dq)):
        bound = getattr(limits, kind)
        assert np.all((values >= bound[:, 0]) & (values <= bound[:, 1]))
    use = [
        np.abs(values / getattr(limits, kind)[:, 1]).max(axis=0)
        for kind, values in (("acceleration", motion.ddq), ("velocity", motion.dq))
    ]
    ranges = np.ptp(motion.q, axis=0) / np.ptp(limits.position, axis=1)
    assert np.all(np.max([*use, ranges], axis=0) > 0.6)
    np.testing.assert_allclose(
        np.gradient(motion.q, PERIOD, axis=0)[1:-1], motion.dq[1:-1], atol=1e-4
    )


def test_a_late_torque_is_late_by_what_the_truth_says():
    injected = late_torque(scara_arm(), 0, 1.0, np.random.default_rng(0))
    (change,) = injected.arm.torque_changes
    delay, unit = injected.parameters["delay"]
    t = np.arange(2000) * PERIOD
    ramp = np.repeat((3.0 * t)[:, None, None], 2, axis=1)
    late = change(ramp, PERIOD)
    np.testing.assert_allclose(late[100:, 0, 0], 3.0 * (t[100:] - delay), atol=1e-12)
    assert unit == "s"


def test_a_lag_keeps_constants_and_delays_ramps_by_its_time():
    t = np.arange(5000) * PERIOD
    ramp = (2.0 + 3.0 * t)[:, None, None]
    lagged = _low_pass(ramp, 0.02, PERIOD)
    np.testing.assert_allclose(lagged[-1000:], ramp[-1000:] - 3.0 * 0.02, atol=1e-9)
    np.testing.assert_allclose(_low_pass(np.ones((50, 1, 1)), 0.02, PERIOD), 1.0)


def test_a_lag_answers_a_wave_as_the_continuous_filter_does():
    t, time, omega = np.arange(8000) * PERIOD, 0.01, 2 * np.pi * 5.0
    lagged = _low_pass(np.sin(omega * t)[:, None, None], time, PERIOD)[2000:, 0, 0]
    phase, gain = np.arctan(omega * time), 1 / np.hypot(1, omega * time)
    np.testing.assert_allclose(lagged, gain * np.sin(omega * t[2000:] - phase), atol=2e-4)


def test_an_unbent_spring_joint_is_the_rigid_arm_with_a_rotor():
    robot, rng = imi_scara(), np.random.default_rng(0)
    flexible = _with_spring_joint(robot, Transmission(1, 0.3, lambda x, v: x, 0.0))
    q, dq, ddq = rng.standard_normal((3, 2))
    rigid = np.array(inverse_dynamics(robot, list(q), list(dq), list(ddq)), dtype=float)
    bent = np.array(inverse_dynamics(flexible, *([*x, 0.0] for x in (q, dq, ddq))), dtype=float)
    rotor = 0.3 * (ddq[0] + ddq[1])
    np.testing.assert_allclose(bent[:2], rigid + rotor, rtol=1e-12)
    assert bent[2] == pytest.approx(rigid[1])


def test_the_commanded_torque_moves_the_arm_as_the_log_says(short):
    rng = np.random.default_rng(7)
    arm = scara_arm()
    noise = Noise.draw("white", (0.5, 0.1), rng)
    laboratory = build_laboratory(arm, arm, noise, 1, rng)
    reference = random_fourier_motion(imi_scara().limits, 3.0, 1.5, PERIOD, rng)
    log = laboratory.log(reference, rng, 1, 0.0)
    assert log.lead == round(LEAD_IN / PERIOD)
    error = np.abs(log.q[log.lead :, :, 0] - reference.q).max()
    assert error < 0.03


def test_a_control_that_shakes_the_arm_leaves_no_recording(short, monkeypatch):
    """An arm that moves as it should is fast enough for half the speed that it should have."""
    rng = np.random.default_rng(7)
    arm = scara_arm()
    laboratory = build_laboratory(arm, arm, Noise.draw("white", (0.5, 0.1), rng), 1, rng)
    reference = random_fourier_motion(imi_scara().limits, 3.0, 1.5, PERIOD, rng)
    monkeypatch.setattr("studies.bench.laboratory.SHAKEN", 0.5)
    with pytest.raises(OedError, match="shakes the arm: joint"):
        laboratory.log(reference, rng, 1, 0.0)


def test_alone_a_joint_moves_less_than_the_diagonal_of_the_mass_matrix():
    least, mean = least_inertia(imi_scara(), np.random.default_rng(0))
    assert np.all(least > 0)
    assert np.all(least < mean)


def test_forms_that_an_arm_cannot_show_are_not_asked_of_it():
    assert "tilted_base" not in {form.key for form in forms_of("plain", "vertical")}
    assert "tilted_base" in {form.key for form in forms_of("plain", "scara")}


def test_the_truth_survives_the_file(tmp_path, short):
    case = Case("pair", "scara", ("spring", "landscape"), 1.0, "white", False, 2)
    truth = make_dataset(case, tmp_path / "data")
    truth.write(tmp_path / "truth.json")
    assert Truth.read(tmp_path / "truth.json") == truth
    assert len({hidden.joint for hidden in truth.hidden}) == 2
