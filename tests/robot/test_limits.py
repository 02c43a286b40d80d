"""Joint limits."""

import numpy as np
import pytest

from oed.robot import JointLimits


def test_symmetric_limits_have_both_sides_and_leave_the_rest_free() -> None:
    limits = JointLimits.symmetric(position=(1.5, 2.0), velocity=(8.0, 9.0))
    assert limits.position.tolist() == [[-1.5, 1.5], [-2.0, 2.0]]
    assert limits.velocity.tolist() == [[-8.0, 8.0], [-9.0, 9.0]]
    assert np.isinf(limits.torque).all()


def test_a_lower_bound_above_its_upper_is_refused_by_joint() -> None:
    limits = JointLimits.unlimited(2)
    with pytest.raises(ValueError, match="position limit of joint 2: lower 1 is not below"):
        limits.with_(position=np.array([[-1.0, 1.0], [1.0, -1.0]]))
