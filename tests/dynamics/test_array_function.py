"""A CasADi function on arrays as they lie gives what its own call gives."""

import casadi
import numpy as np
import pytest

from oed.dynamics.array_function import array_function

x, y, none = casadi.SX.sym("x", 3), casadi.SX.sym("y", 2, 3), casadi.SX.sym("none", 0)


def test_gives_what_the_function_gives_and_keeps_it():
    rng = np.random.default_rng(5)
    function = casadi.Function("f", [x, y, none], [y @ x, casadi.SX(0, 1), casadi.diag(x)])
    call = array_function(function)
    made = []
    for _ in range(3):
        a, b = rng.normal(size=3), rng.normal(size=(2, 3))
        made.append((call(a, b, np.empty(0)), [np.array(own) for own in function(a, b, [])]))
    for found, expected in made:
        for one, other in zip(found, expected, strict=True):
            assert one.shape == other.shape
            np.testing.assert_array_equal(one, other)


def test_what_is_not_dense_is_refused():
    sparse = casadi.SX.sym("s", casadi.Sparsity.lower(2))
    with pytest.raises(ValueError, match="f: its argument i0 is not dense"):
        array_function(casadi.Function("f", [sparse], [sparse]))
