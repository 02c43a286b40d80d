"""A span of white columns."""

import numpy as np
import pytest

from oed.estimation.noise_floor.linear_fit import factorise


@pytest.mark.parametrize("columns", [4, 7, 44])
def test_a_span_leaves_what_least_squares_leave(columns):
    """Also where columns are more than the rows: the shortest parameters of a perfect fit."""
    rng = np.random.default_rng(6)
    white, torque = rng.normal(size=(2, 9, columns)), rng.normal(size=(2, 9))
    span, whole = factorise(white), white.reshape(18, -1)
    fitted = whole @ np.linalg.lstsq(whole, torque.ravel(), rcond=None)[0]
    assert span.rank == min(columns, 18)
    assert span.residual(torque).ravel() == pytest.approx(torque.ravel() - fitted, abs=1e-9)
    parameters = span.inverse @ span.coordinates(torque)
    assert whole @ parameters == pytest.approx(fitted, abs=1e-9)
