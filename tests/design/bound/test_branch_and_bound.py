import casadi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oed.design.bound.branch_and_bound import Boxes, SmoothFunction, prove_maximum
from oed.design.bound.tape import Tape

X = casadi.SX.sym("x", 2)
FIXED = casadi.SX.sym("a", 1)


def expression() -> casadi.SX:
    u, v = X[0], X[1]
    return (
        casadi.sin(3 * u) * v
        - v**2 * casadi.cos(u)
        + 0.3 * u**3
        - FIXED[0] * u * v
        + casadi.tanh(u) * casadi.exp(-(v**2))
        + casadi.fabs(v)
    )


def whole(fixed: float, cells: int = 2) -> Boxes:
    centres = (np.arange(cells) + 0.5) * (2 / cells) - 1
    middle = np.stack(np.meshgrid(centres, centres), axis=-1).reshape(-1, 2)
    return Boxes(middle, np.full_like(middle, 1 / cells), np.full((len(middle), 1), fixed))


def test_a_tape_gives_casadis_values() -> None:
    function = casadi.Function(
        "f", [casadi.vertcat(X, FIXED)], [casadi.vertcat(expression(), X[0])]
    )
    points = np.random.default_rng(0).uniform(-2, 2, (50, 3))
    expected = [np.array(function(p)).ravel() for p in points]
    np.testing.assert_allclose(Tape(function).values(points), expected, rtol=1e-13, atol=1e-13)


@given(st.integers(0, 10**6), st.floats(0.001, 3.0))
@settings(max_examples=12, deadline=None)
def test_an_interval_contains_every_value_inside(seed: int, width: float) -> None:
    rng = np.random.default_rng(seed)
    tape = Tape(casadi.Function("f", [casadi.vertcat(X, FIXED)], [expression()]))
    lower = rng.uniform(-4, 4, (5, 3))
    upper = lower + width * rng.random((5, 3))
    low, high = tape.intervals(lower, upper)
    for share in rng.random((30, 3)):
        value = tape.values(lower + share * (upper - lower))
        assert (value >= low - 1e-12).all()
        assert (value <= high + 1e-12).all()


@pytest.mark.parametrize("fixed", [-1.0, 0.0, 2.0])
def test_the_bound_holds_and_is_as_tight_as_asked(fixed: float) -> None:
    function = SmoothFunction.of(expression(), X, FIXED)
    proof = prove_maximum(function, whole(fixed), tolerance=0.01)
    axis = np.linspace(-1, 1, 401)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    dense = function.slopes.values(np.column_stack([grid, np.full(len(grid), fixed)]))[:, 0].max()
    assert dense <= proof.upper <= proof.attained + 0.0101 * abs(proof.attained)
    assert proof.attained <= proof.upper
    assert proof.attained == pytest.approx(dense, rel=0.02)


def test_an_interrupted_proof_is_still_a_proof() -> None:
    function = SmoothFunction.of(expression(), X, FIXED)
    finished = prove_maximum(function, whole(1.0), tolerance=0.001)
    interrupted = prove_maximum(function, whole(1.0), tolerance=0.001, most_boxes=20)
    assert interrupted.boxes <= 20
    assert interrupted.upper >= finished.attained


def test_boxes_end_where_a_sign_changes() -> None:
    value = casadi.sign(X[0]) * X[1] + 0 * FIXED[0]
    function = SmoothFunction.of(value, X, FIXED)
    proof = prove_maximum(function, whole(0.0), tolerance=1e-3)
    assert proof.upper == pytest.approx(1.0, abs=2e-3)
