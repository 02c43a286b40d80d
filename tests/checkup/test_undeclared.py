"""The inertia of a rotor that nobody declared is no fault of the log."""

import pytest

from oed.checkup.search import find_cause
from tests.checkup.hanging_arm import data_set
from tests.checkup.simulated_arm import model_of, processed


# Of each a fit by rigid body and friction alone was better under a turned gravity.
@pytest.mark.parametrize("seed", [0, 2, 3, 6])
def test_rotors_that_are_not_declared_are_no_turned_gravity(seed):
    data = data_set(seed)
    assert find_cause(data, model_of(data.robot), processed(data)).cause is None
