"""A span of white columns, and what is added to it."""

import numpy as np
import pytest

from oed.estimation.noise_floor.linear_fit import factorise


@pytest.mark.parametrize("added", [0, 3, 40])
def test_a_span_with_more_columns_is_that_of_all_of_them(added):
    """Also where these are more than the rows: the shortest parameters of a perfect fit."""
    rng = np.random.default_rng(6)
    first, more = rng.normal(size=(2, 9, 4)), rng.normal(size=(2, 9, added))
    span = factorise(first).extended(more)
    whole = np.concatenate([first, more], axis=2).reshape(18, -1)
    torque = rng.normal(size=(2, 9))
    fitted = whole @ np.linalg.lstsq(whole, torque.ravel(), rcond=None)[0]
    assert span.rank == min(4 + added, 18)
    assert span.residual(torque).ravel() == pytest.approx(torque.ravel() - fitted, abs=1e-9)
    parameters = span.inverse @ span.coordinates(torque)
    assert whole @ parameters == pytest.approx(fitted, abs=1e-9)
