"""What is known when an effect is tried."""

import numpy as np
import pytest

from oed.dynamics.motion import Motion
from tests.dynamics.effects.arms import context_of, scara, smooth_motion


def test_a_further_motion_widens_what_is_covered_and_nothing_else():
    known = context_of(scara())
    slow = smooth_motion(scara())
    # Half the amplitude at four times the rate, elsewhere.
    fast = Motion(slow.t / 4, 0.5 * slow.q + 2.0, 2 * slow.dq, 8 * slow.ddq)
    both = known.covering(fast)
    assert both.position_range[:, 0] == pytest.approx(slow.q.min(axis=0))
    assert both.position_range[:, 1] == pytest.approx(0.5 * slow.q.max(axis=0) + 2.0)
    assert both.top_speed == pytest.approx(2 * known.top_speed)
    assert both.top_acceleration == pytest.approx(8 * known.top_acceleration)
    assert np.all(both.peak_torque > known.peak_torque)
    assert both.duration == known.duration
    assert both.recordings == known.recordings
    again = known.covering(slow)
    for name in ("position_range", "top_speed", "top_acceleration", "peak_torque"):
        assert getattr(again, name) == pytest.approx(getattr(known, name))
