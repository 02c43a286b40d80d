import numpy as np
import pytest

from oed.dynamics.effects import Viscous
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import sin
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.control import Controller
from oed.experiment.disturbance import CalibrationFailed, Disturbance, calibrate
from oed.experiment.friction_memory import BristleFriction
from oed.experiment.observer import HighGainObserver
from oed.experiment.plant import TruePlant
from oed.experiment.reference import lead_in
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import Setup, SimulationDiverged, run, simulate
from oed.robot import Joint, JointLimits, Robot
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS, imi_scara

MASS, LENGTH, GRAVITY = 2.0, 0.5, 9.81


def pendulum() -> Robot:
    """A point mass on a horizontal axis, hanging at q = 0."""
    joint = Joint(
        name="swing",
        kind="revolute",
        parent=-1,
        axis=np.array([0.0, 0.0, 1.0]),
        R_PJ=np.eye(3),
        p_PJ=np.zeros(3),
        link="bob",
        R_LJ=np.eye(3),
        p_LJ=np.zeros(3),
    )
    inertia = MASS * LENGTH**2
    parameters = np.array([MASS, MASS * LENGTH, 0, 0, 0.0, 0, 0, inertia, 0, inertia])
    return Robot(
        "pendulum", (joint,), parameters, np.array([GRAVITY, 0.0, 0.0]), JointLimits.unlimited(1)
    )


def free(joints: int) -> Controller:
    """A controller too weak to be felt."""
    return Controller((1e-12,) * joints, (1e-12,) * joints, HighGainObserver.uniform(joints))


def sway(amplitude, rate, samples: int, period: float = 0.001) -> Motion:
    t = np.arange(samples) * period
    a, w = np.asarray(amplitude, dtype=float), np.asarray(rate, dtype=float)
    phase = t[:, None] * w
    return Motion(t, a * np.sin(phase), a * w * np.cos(phase), -a * w**2 * np.sin(phase))


def scara_setup(**changes) -> Setup:
    plant = TruePlant(
        imi_scara(),
        (Viscous(0), Viscous(1)),
        IMI_VISCOUS,
        tuple(BristleFriction(j, c) for j, c in enumerate(IMI_COULOMB)),
    )
    gains = Controller((3320.0, 166.6), (101.4, 3.31), HighGainObserver.paper())
    return Setup(plant, gains, **changes)


def test_small_swings_have_the_period_of_a_pendulum():
    setup = Setup(TruePlant(pendulum()), free(1), lead_in=0.001)
    rest = Motion(np.arange(4000) * 1e-3, *(np.zeros((4000, 1)) for _ in range(3)))
    held = Motion(rest.t, rest.q + 0.01, rest.dq, rest.ddq)
    log = run(setup, held, np.random.default_rng(0), runs=1)
    expected = 0.01 * np.cos(np.sqrt(GRAVITY / LENGTH) * (log.t[:, 0] - log.t[0, 0]))
    # The period grows by a sixteenth of the amplitude squared: 6e-6 of 6 cycles.
    np.testing.assert_allclose(log.q[:, 0, 0], expected, atol=0.01 * 2.5e-4)


def test_energy_is_conserved_without_friction():
    setup = Setup(TruePlant(pendulum()), free(1), lead_in=0.001)
    motion = Motion(np.arange(5000) * 1e-3, np.full((5000, 1), 2.0), *[np.zeros((5000, 1))] * 2)
    log = run(setup, motion, np.random.default_rng(0), runs=1)
    energy = (
        MASS * LENGTH * (0.5 * LENGTH * log.dq[:, 0, 0] ** 2 - GRAVITY * np.cos(log.q[:, 0, 0]))
    )
    assert np.ptp(energy) < 1e-8 * np.abs(energy).max()


def test_command_is_the_torque_that_the_motion_needs():
    setup = scara_setup()
    reference = sway((0.8, 0.9), (1.7, 1.3), 3000)
    log = run(setup, reference, np.random.default_rng(0), runs=1)
    t, q, dq = log.t[:, 0], log.q[:, :, 0], log.dq[:, :, 0]
    ddq = np.gradient(dq, 1e-3, axis=0)
    model = TorqueModel.standard(setup.plant.robot)
    truth = np.concatenate(
        [setup.plant.robot.parameters, *zip(IMI_COULOMB, IMI_VISCOUS, strict=True)]
    )
    needed = model.torque(truth, Motion(t, q, dq, ddq))
    # Held for a period, the command of an instant is the mean need of the period after it.
    middle = 0.5 * (needed[:-1] + needed[1:])
    steady = (np.abs(dq[:-1]).min(axis=1) > 0.2) & (np.arange(len(t) - 1) > log.lead)
    error = (log.command[:-1, :, 0] - middle)[steady]
    assert steady.sum() > 1000
    assert np.sqrt((error**2).mean(axis=0)).max() < 0.02


def test_bristles_hold_below_the_friction_and_slide_above_it():
    robot = imi_scara()
    for push, moves in ((0.9, False), (1.1, True)):
        plant = TruePlant(
            robot,
            (Viscous(0), Viscous(1)),
            (7.0, 0.8),
            (BristleFriction(0, 2.61), BristleFriction(1, 1.46)),
            (lambda state, load, push=push: {1: -1.46 * push},),
        )
        still = Motion(np.arange(3000) * 1e-3, *[np.zeros((3000, 2))] * 3)
        log = run(Setup(plant, free(2)), still, np.random.default_rng(0), runs=1)
        # Held, the bristles still bend; by how much their stiffness says.
        assert (abs(log.q[-1, 1, 0]) > 0.05) == moves


def test_extra_torque_is_felt():
    def spring(state, load):
        return {1: 0.5 * sin(state.q[1])}

    plain = scara_setup()
    sprung = Setup(
        TruePlant(
            plain.plant.robot,
            plain.plant.effects,
            plain.plant.parameters,
            plain.plant.memory,
            (spring,),
        ),
        plain.controller,
    )
    reference = sway((0.5, 0.9), (1.0, 1.3), 2000)
    without, with_ = (simulate(s, reference, np.random.default_rng(0)).tau for s in (plain, sprung))
    expected = 0.5 * np.sin(reference.q[:, 1])
    assert np.abs((with_ - without)[500:, 1] - expected[500:]).max() < 0.05


def test_same_seed_same_recording_other_seed_another():
    setup = scara_setup(disturbance=Disturbance((1.0, 0.2), (10.0, 10.0)))
    reference = sway((0.5, 0.5), (1.0, 1.3), 500)
    first, again, other = (
        simulate(setup, reference, np.random.default_rng(s), repetitions=2).tau for s in (1, 1, 2)
    )
    assert np.array_equal(first, again)
    assert not np.allclose(first, other)


def test_position_is_read_in_steps_of_the_resolver():
    sensors = Sensors.resolvers(2, 12)
    recording = simulate(
        scara_setup(sensors=sensors), sway((0.5, 0.5), (1.0, 1.3), 800), np.random.default_rng(0)
    )
    steps = recording.q / (2 * np.pi / 2**12) - 0.5
    assert np.abs(steps - np.round(steps)).max() < 1e-6
    assert recording.dq is not None


def test_logged_torque_is_late_by_the_delay():
    reference = sway((0.5, 0.5), (2.0, 1.3), 1500)
    prompt, late = (
        simulate(scara_setup(sensors=s), reference, np.random.default_rng(0))
        for s in (Sensors(), Sensors(torque_delay=(0.02, 0.0)))
    )
    np.testing.assert_allclose(late.tau[20:, 0], prompt.tau[:-20, 0], atol=1e-9)
    np.testing.assert_allclose(late.tau[:, 1], prompt.tau[:, 1])


def test_periodic_motion_runs_through_without_a_stop():
    period = 2 * np.pi / 1.5
    samples = round(period / 0.001)
    reference = sway((0.5, 0.4), (2 * np.pi / (samples * 1e-3),) * 2, samples)
    recording = simulate(
        scara_setup(), reference, np.random.default_rng(0), repetitions=3, periodic=True
    )
    assert recording.repetitions == 3
    assert len(recording) == 3 * samples
    folded = recording.tau.reshape(3, samples, 2)
    assert np.abs(folded[0] - folded[2]).max() < 1e-6


def test_disturbance_has_its_level_and_colour():
    disturbance = Disturbance((2.0, 0.5), (10.0, 100.0))
    push = disturbance.sample(4000, 400, 0.001, np.random.default_rng(0))
    np.testing.assert_allclose(push.std(axis=(0, 2)), [2.0, 0.5], rtol=0.02)
    lag = 50  # samples: the correlation is exp(-corner lag)
    correlation = (push[lag:] * push[:-lag]).mean(axis=(0, 2)) / push.var(axis=(0, 2))
    np.testing.assert_allclose(correlation, np.exp([-0.5, -5.0]), atol=0.02)


def test_calibration_hits_the_variances():
    setup = scara_setup(sensors=Sensors.resolvers(2, 16))
    reference = sway((0.8, 0.9), (1.7, 1.3), 3000)
    target = np.array([3.069, 0.157])

    def variances(disturbance, seed=0):
        recording = simulate(
            scara_setup(sensors=setup.sensors, disturbance=disturbance),
            reference,
            np.random.default_rng(seed),
            repetitions=20,
        )
        return recording.tau.reshape(20, -1, 2).var(axis=0, ddof=1).mean(axis=0)

    found = calibrate(Disturbance((1.0, 0.3), (10.0, 10.0)), target, variances)
    np.testing.assert_allclose(variances(found), target, rtol=0.01)
    # 19 x 3 s, correlated over 0.2 s, are some 280 independent samples: 8 per cent.
    np.testing.assert_allclose(variances(found, seed=1), target, rtol=0.25)
    with pytest.raises(CalibrationFailed, match="joint"):
        calibrate(found, target * 1e-6, variances)


def test_lead_in_goes_from_rest_to_the_start_of_the_motion():
    reference = sway((0.8, -0.9), (1.7, 1.3), 10)
    approach = lead_in(reference, 1.5, 0.001)
    assert len(approach) == 1500
    np.testing.assert_allclose(approach.dq[0], 0, atol=1e-12)
    np.testing.assert_allclose(approach.ddq[0], 0, atol=1e-12)
    joined = np.concatenate([approach.q, reference.q])
    assert np.abs(np.diff(joined, 3, axis=0)).max() < 1e-6
    np.testing.assert_allclose(
        np.gradient(approach.q, 1e-3, axis=0)[5:-5], approach.dq[5:-5], atol=1e-5
    )


def test_refuses_another_sampling_period():
    with pytest.raises(ValueError, match="sampled every"):
        simulate(scara_setup(), sway((0.1, 0.1), (1, 1), 50, 0.002), np.random.default_rng(0))


def test_says_when_the_arm_runs_away():
    gains = Controller((3e5, 3e4), (1e5, 1e4), HighGainObserver.paper())
    setup = Setup(scara_setup().plant, gains)
    with pytest.raises(SimulationDiverged) as caught:
        simulate(setup, sway((0.5, 0.5), (1.0, 1.3), 20000), np.random.default_rng(0))
    assert caught.value.instant >= 0
