"""Criteria against closed forms and NumPy; slopes against finite differences."""

import numpy as np
import pytest

from oed.design import criteria

RNG = np.random.default_rng(7)
COLUMNS = RNG.standard_normal((20, 3, 5))
LAMBDA = criteria.information(COLUMNS)


def test_of_a_diagonal_matrix_are_known() -> None:
    matrix = np.diag([1.0, 10.0, 100.0])
    assert criteria.condition(matrix) == pytest.approx(100)
    assert criteria.log10_det(matrix) == pytest.approx(3)
    assert criteria.trace_inverse(matrix) == pytest.approx(1.11)
    assert criteria.smallest_eigenvalue(matrix) == pytest.approx(1)
    assert criteria.cost(matrix, "J_k") == pytest.approx(2)
    assert criteria.cost(matrix, "J_d") == pytest.approx(-3)
    assert criteria.cost(matrix, "E") == pytest.approx(0)


def test_singular_information_costs_infinity() -> None:
    matrix = np.diag([1.0, 0.0])
    assert all(criteria.cost(matrix, c) == np.inf for c in criteria.CRITERIA)


def test_every_form_of_covariance_means_the_same() -> None:
    variances = np.array([0.5, 2.0, 3.0])
    by_joint = criteria.information(COLUMNS, variances)
    matrix = criteria.information(COLUMNS, np.diag(variances))
    rows = criteria.information(COLUMNS, np.diag(np.tile(variances, 20)))
    np.testing.assert_allclose(matrix, by_joint)
    np.testing.assert_allclose(rows, by_joint)


def test_prior_information_adds() -> None:
    np.testing.assert_allclose(criteria.information(COLUMNS, prior=np.eye(5)), LAMBDA + np.eye(5))


def test_refuses_a_covariance_of_another_size() -> None:
    with pytest.raises(ValueError, match="expected"):
        criteria.information(COLUMNS, np.ones(4))


def test_column_scaling_gives_a_unit_diagonal() -> None:
    s = criteria.column_scaling(LAMBDA)
    np.testing.assert_allclose(np.diag(LAMBDA * np.outer(s, s)), 1.0)


@pytest.mark.parametrize("criterion", criteria.CRITERIA)
@pytest.mark.parametrize("exponent", [4.0, np.inf])
def test_slopes_are_derivatives(criterion, exponent) -> None:
    step = RNG.standard_normal((5, 5))
    step = 1e-6 * (step + step.T)
    above, below = (
        criteria.cost_and_slope(LAMBDA + sign * step, criterion, exponent)[0] for sign in (1, -1)
    )
    slope = criteria.cost_and_slope(LAMBDA, criterion, exponent)[1]
    assert above - below == pytest.approx(2 * (slope * step).sum(), rel=1e-4)


@pytest.mark.parametrize("criterion", criteria.CRITERIA)
def test_the_smooth_cost_bounds_the_exact_one_and_tends_to_it(criterion) -> None:
    exact = criteria.cost(LAMBDA, criterion)
    rough, fine = (criteria.cost_and_slope(LAMBDA, criterion, p)[0] for p in (4.0, 2000.0))
    assert rough >= exact - 1e-12
    assert fine == pytest.approx(exact, abs=1e-3)
