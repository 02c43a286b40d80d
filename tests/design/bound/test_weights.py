"""D-optimal designs that are known in closed form."""

import numpy as np
import pytest

from oed.design.bound.weights import WeightsNotFound, optimal_weights


def polynomial(points: np.ndarray, degree: int) -> np.ndarray:
    return points[:, None, None] ** np.arange(degree + 1)


def unbalanced(atoms: int) -> np.ndarray:
    return np.zeros((atoms, 0))


@pytest.mark.parametrize(
    ("degree", "support"),
    [(1, [-1.0, 1.0]), (2, [-1.0, 0.0, 1.0]), (3, [-1.0, -np.sqrt(1 / 5), np.sqrt(1 / 5), 1.0])],
)
def test_polynomial_regression_on_an_interval(degree: int, support: list[float]) -> None:
    # Support: zeros of (1 - x^2) P_d'(x), with equal weights (Guest 1958, Hoel 1958).
    points = np.union1d(np.linspace(-1, 1, 201), support)
    design = optimal_weights(polynomial(points, degree), unbalanced(len(points)))
    exact = polynomial(np.array(support), degree)[:, 0]
    best = np.linalg.slogdet(exact.T @ exact / len(support))[1]
    assert np.linalg.slogdet(design.information)[1] == pytest.approx(best, abs=1e-5)
    for x in support:
        assert design.weights[np.abs(points - x) < 0.03].sum() == pytest.approx(
            1 / len(support), abs=1e-3
        )


def test_the_multiplier_of_the_mass_is_the_number_of_parameters() -> None:
    rng = np.random.default_rng(0)
    design = optimal_weights(rng.standard_normal((80, 2, 4)), unbalanced(80))
    assert design.mass_multiplier == pytest.approx(4.0, abs=1e-4)
    assert design.weights.sum() == pytest.approx(1.0, abs=1e-6)


def test_the_dual_is_feasible_on_every_atom() -> None:
    rng = np.random.default_rng(1)
    rows, balance = rng.standard_normal((300, 2, 5)), rng.standard_normal((300, 3))
    design = optimal_weights(rows, balance)
    told = np.einsum("irc,cd,ird->i", rows, np.linalg.inv(design.information), rows)
    value = told - balance @ design.multipliers
    assert value.max() <= design.mass_multiplier * (1 + 1e-3)
    np.testing.assert_allclose(design.weights @ balance, 0.0, atol=1e-5)
    assert (design.weights >= 0).all()


def test_an_equality_can_only_cost_information() -> None:
    rng = np.random.default_rng(2)
    rows, balance = rng.standard_normal((200, 1, 4)), rng.standard_normal((200, 6))
    free = optimal_weights(rows, unbalanced(200))
    tied = optimal_weights(rows, balance)
    assert np.linalg.slogdet(tied.information)[1] < np.linalg.slogdet(free.information)[1]


def test_agrees_with_a_general_convex_solver() -> None:
    cvxpy = pytest.importorskip("cvxpy")
    rng = np.random.default_rng(3)
    rows, balance = rng.standard_normal((40, 2, 3)), rng.standard_normal((40, 2))
    design = optimal_weights(rows, balance)
    w = cvxpy.Variable(40, nonneg=True)
    information = sum(w[i] * (rows[i].T @ rows[i]) for i in range(40))
    program = cvxpy.Problem(
        cvxpy.Maximize(cvxpy.log_det(information)), [cvxpy.sum(w) == 1, balance.T @ w == 0]
    )
    program.solve(solver="CLARABEL")
    assert np.linalg.slogdet(design.information)[1] == pytest.approx(program.value, abs=1e-4)


def test_says_so_when_nothing_satisfies_the_equalities() -> None:
    rows = np.random.default_rng(4).standard_normal((30, 1, 3))
    with pytest.raises(WeightsNotFound) as caught:
        optimal_weights(rows, np.ones((30, 1)))
    assert caught.value.residual > 1e-3
