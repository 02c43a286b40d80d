import numpy as np
import pytest

from oed.dynamics.effects import Viscous
from oed.dynamics.motion import Motion
from oed.experiment.control import Controller
from oed.experiment.disturbance import Disturbance
from oed.experiment.drake_experiment import run_on_drake
from oed.experiment.friction_memory import BristleFriction
from oed.experiment.observer import HighGainObserver
from oed.experiment.plant import TruePlant
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import Setup, run
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS, imi_scara


def setup(**changes) -> Setup:
    plant = TruePlant(
        imi_scara(),
        (Viscous(0), Viscous(1)),
        IMI_VISCOUS,
        (
            BristleFriction(0, IMI_COULOMB[0], static_rise=1.0),
            BristleFriction(1, IMI_COULOMB[1]),
        ),
    )
    gains = Controller((3557.0, 178.0), (99.9, 3.1), HighGainObserver.paper())
    return Setup(
        plant, gains, disturbance=Disturbance((1.0, 0.2), (10.0, 10.0)), lead_in=0.1, **changes
    )


def reference() -> Motion:
    t = np.arange(200) * 1e-3
    a, w = np.array([0.6, 0.8]), np.array([4.0, 3.0])
    phase = t[:, None] * w
    return Motion(t, a * np.sin(phase), a * w * np.cos(phase), -a * w**2 * np.sin(phase))


def test_the_fast_loop_and_drake_are_one_experiment():
    ours, drake = (
        runner(setup(), reference(), np.random.default_rng(0), runs=1)
        for runner in (run, run_on_drake)
    )
    for field, tolerance in (("q", 1e-6), ("velocity", 1e-4), ("command", 1e-2)):
        np.testing.assert_allclose(
            getattr(ours, field), getattr(drake, field), rtol=0, atol=tolerance
        )


def test_with_resolvers_they_part_by_steps_only():
    # Which side of a step a position falls on is chaos: one step, not more, in position.
    sensors = Sensors.resolvers(2, 16)
    ours, drake = (
        runner(setup(sensors=sensors), reference(), np.random.default_rng(0), runs=1)
        for runner in (run, run_on_drake)
    )
    step = 2 * np.pi / 2**16
    assert np.abs(ours.measured - drake.measured).max() < 1.5 * step
    assert np.abs(ours.command - drake.command).mean() < 0.2


def test_refuses_what_drake_would_run_without():
    plain = setup()
    secret = TruePlant(plain.plant.robot, extra=(lambda state, load: {0: load[0]},))
    with pytest.raises(ValueError, match="load"):
        run_on_drake(Setup(secret, plain.controller), reference(), np.random.default_rng(0), runs=1)
