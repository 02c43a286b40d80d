"""All signs reversed: what the file's inertials say, and what friction says to it."""

import numpy as np
import pytest

from oed.checkup.by_inertials import all_reversed
from oed.checkup.projection import Projection
from oed.experiment.dataset import DataSet
from tests.checkup.simulated_arm import arm


@pytest.mark.parametrize(
    ("braking", "named"),
    [
        ((-0.1, -0.02, -0.03), True),
        ((-0.2, 0.1, -0.03), False),
        ((-0.2, -0.02, 0.1), False),  # whether or not the joint follows the file
    ],
)
def test_all_signs_are_reversed_unless_the_friction_of_a_joint_brakes(braking, named):
    projection = Projection(
        slope=-np.ones(3),
        correlation=np.array([-0.95, -0.99, -0.5]),
        braking=np.array(braking),
        friction=-0.05,
        needed=np.ones(3),
        measured=np.ones(3),
    )
    data = DataSet("three links", "tests", "none", arm(), "measured")
    assert (all_reversed(data, projection) is not None) is named
