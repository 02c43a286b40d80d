"""Friction of a joint that warms up: largest cold, the same clock for each recording."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.thermal import ThermalDrift
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
