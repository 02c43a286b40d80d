"""Friction of a joint that warms up, by a clock or by its thermometer."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.context import Context
from oed.dynamics.effects.effect import State
from oed.dynamics.effects.entries.history import MEASURED
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.thermal import ThermalDrift, WarmFriction
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import parameters_of, scara, smooth_motion

MOTION = smooth_motion(scara())


def test_columns_decay_with_the_time_constant() -> None:
    columns = evaluate(ThermalDrift(1, 4.0), MOTION, 2)
    decay = np.exp(-MOTION.t / 4.0)
    assert columns[:, 1, 0] == pytest.approx(decay * MOTION.dq[:, 1])
    assert columns[:, 1, 1] == pytest.approx(decay * np.sign(MOTION.dq[:, 1]))
    assert not columns[:, 0].any()


def test_each_recording_is_a_session_unless_told_otherwise() -> None:
    later = Motion(MOTION.t + 60.0, MOTION.q, MOTION.dq, MOTION.ddq)
    own = evaluate(ThermalDrift(1, 4.0), MOTION, 2)
    assert evaluate(ThermalDrift(1, 4.0), later, 2) == pytest.approx(own)
    shared = evaluate(ThermalDrift(1, 4.0, start=0.0), later, 2)
    assert shared == pytest.approx(np.exp(-15.0) * own)


def test_refuses_a_time_constant_of_zero() -> None:
    with pytest.raises(ValueError, match="time_constant"):
        ThermalDrift(0, 0.0)


def test_a_clock_that_goes_on_makes_one_session_of_a_single_recording() -> None:
    model = TorqueModel.standard(scara())
    parameters = parameters_of(model)

    def clocks(later: float, *motions: Motion) -> tuple[float, ...]:
        next_one = dataclasses.replace(MOTION, t=MOTION.t + later)
        context = Context.of(model, parameters, motions, later=[next_one])
        return CATALOGUE["thermal_drift"].shapes_for(context, 0)[1].grid

    second = dataclasses.replace(MOTION, t=MOTION.t + 20.0)
    assert clocks(60.0, MOTION) == (1.0,)
    assert clocks(0.0, MOTION) == (0.0,)
    # Two recordings can tell by themselves which it is.
    assert clocks(60.0, MOTION, second) == (0.0, 1.0)


@pytest.mark.parametrize(("durations", "possible"), [(0.1, False), (3.0, True)])
def test_what_a_slow_change_would_come_to_is_no_matter(durations: float, *, possible: bool) -> None:
    """Within the log friction falls to a seventh, or to three quarters."""
    model = TorqueModel.standard(scara())
    context = Context.of(model, parameters_of(model), [MOTION])
    last = context.friction_at_top_speed(1)
    entry = CATALOGUE["thermal_drift"]
    values = (durations * context.duration, 0.0)
    reason = entry.plausible(context, 1, values, np.array([0.0, 6 * last]))
    assert (reason is None) is possible


def warmed(motion: Motion, *temperature: float) -> Motion:
    """The motion of an arm whose joints are as warm as that, the second one ever warmer."""
    ramp = np.linspace(0.0, 10.0, len(motion))[:, None] * [0.0, 1.0]
    return dataclasses.replace(motion, temperature=np.array(temperature) + ramp)


def test_friction_follows_the_thermometer() -> None:
    motion = warmed(MOTION, 20.0, 25.0)
    assert motion.temperature is not None
    warmer = motion.temperature[:, 1] - 30.0
    columns = evaluate(WarmFriction(1, 30.0), motion, 2)
    assert columns[:, 1, 0] == pytest.approx(warmer * MOTION.dq[:, 1])
    assert columns[:, 1, 1] == pytest.approx(warmer * np.sign(MOTION.dq[:, 1]))
    assert not columns[:, 0].any()
    # A part of the motion has its own part of the temperature, seen from a moved joint as well.
    assert evaluate(WarmFriction(1, 30.0), motion[100:], 2) == pytest.approx(columns[100:])
    moved = State.along(motion).with_joint(0, *(x[0] for x in motion.components))
    (viscous, _) = WarmFriction(1, 30.0).entries(moved)
    assert viscous[1] == pytest.approx(columns[:, 1, 0])
    assert motion.fingerprint != MOTION.fingerprint


def test_without_a_temperature_friction_is_that_of_the_base_model() -> None:
    assert not evaluate(WarmFriction(1, 30.0), MOTION, 2).any()


def test_a_thermometer_counts_only_if_all_recordings_have_it_and_it_moves() -> None:
    model = TorqueModel.standard(scara())
    parameters = parameters_of(model)
    entry = CATALOGUE["thermal_drift"]

    def tried(motion: Motion, later: Motion) -> tuple[tuple[float, ...], ...]:
        return entry.further(Context.of(model, parameters, [motion], later=[later]))

    warm = warmed(MOTION, 20.0, 25.0)
    ((measured, _),) = tried(warm, warm)
    steady = dataclasses.replace(MOTION, temperature=np.full((len(MOTION), 2), 20.0))
    assert measured == MEASURED
    assert tried(MOTION, warm) == tried(warm, MOTION) == tried(steady, warm) == ()


@pytest.mark.parametrize(("slope", "possible"), [(0.5, True), (-0.5, True), (1.7, False)])
def test_friction_neither_vanishes_nor_multiplies_within_the_range(
    slope: float, *, possible: bool
) -> None:
    """Over the range it changes by that share of itself at the reference."""
    model = TorqueModel.standard(scara())
    context = Context.of(model, parameters_of(model), [warmed(MOTION, 20.0, 25.0)])
    change = slope * context.friction_at_top_speed(1) / 10.0
    entry = CATALOGUE["thermal_drift"]
    reason = entry.plausible(context, 1, (MEASURED, 0.0), np.array([0.0, change]))
    assert (reason is None) is possible
