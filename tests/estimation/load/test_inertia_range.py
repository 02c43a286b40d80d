"""The interval of a load's inertia is the range that the data allow, however badly they know the centre."""

import numpy as np
import pytest
from scipy.optimize import minimize

from oed.estimation.load.quantities import LinearEstimate, central_inertia, quantities
from oed.robot.inertia import PARAMETER_SYMBOLS

BODY = np.array([2.0, 0.1, -0.06, 0.2, 0.035, 0.002, -0.008, 0.034, 0.007, 0.012])
ENTRIES = {"Ixx": (0, 0), "Ixy": (0, 1), "Ixz": (0, 2), "Iyy": (1, 1), "Iyz": (1, 2), "Izz": (2, 2)}


def estimate(widening):
    rng = np.random.default_rng(4)
    deviation = np.array([0.02, *(0.01 * widening,) * 3, *(0.004,) * 6])
    mixing = rng.normal(size=(10, 10)) / np.sqrt(10)
    factor = deviation[:, None] * mixing
    return LinearEstimate(BODY, factor @ factor.T, np.full(10, np.inf), np.zeros((10, 0))), factor


@pytest.mark.parametrize("widening", [1.0, 12.0])
@pytest.mark.parametrize("name", ENTRIES)
def test_ends_are_the_extremes_on_the_ellipsoid(name, widening):
    linear, factor = estimate(widening)
    found = {q.name: q for q in quantities(linear, BODY, np.full(10, 1.0))}[name]
    entry, reach = ENTRIES[name], linear.reach(np.inf)

    def extreme(side):
        """By a general optimiser, in deviations."""
        scale = np.abs(BODY[4:]).max()
        best = [
            minimize(
                lambda u: -side * central_inertia(BODY + factor @ u)[entry] / scale,
                start,
                constraints={"type": "ineq", "fun": lambda u: reach**2 - u @ u},
                method="SLSQP",
                options={"maxiter": 400},
            )
            for start in np.random.default_rng(1).normal(size=(4, 10))
        ]
        return -side * scale * min(result.fun for result in best)

    low = extreme(-1)
    if name in ("Ixx", "Iyy", "Izz"):
        low = max(low, 0.0)
    assert found.interval == pytest.approx((low, extreme(1)), rel=2e-3, abs=2e-5)


def test_a_centre_that_is_anywhere_leaves_inertia_open():
    linear, _ = estimate(1.0)
    heavy = np.zeros((10, 10))
    heavy[0, 0] = 2.0  # of 2 kg
    vague = LinearEstimate(
        BODY, linear.covariance + heavy, linear.degrees_of_freedom, linear.is_open
    )
    told = {q.name: q for q in quantities(vague, BODY, np.full(10, 1.0))}
    assert told["Ixx"].interval is None
    assert told["mass"].interval is not None


def test_the_ten_are_in_the_order_of_a_link():
    names = [q.name for q in quantities(estimate(1.0)[0], BODY, np.full(10, 1.0))]
    assert names[4:] == list(PARAMETER_SYMBOLS[4:])
