from fractions import Fraction

import numpy as np
import pytest

from oed.estimation.least_squares import batch_least_squares, check_stack
from oed.estimation.prior import Prior
from oed.estimation.recursive import recursive_least_squares
from oed.estimation.streaming import StreamingLeastSquares
from oed.estimation.triangular import NotIdentifiable
from tests.estimation.planar_arm import DEVIATIONS, TRUTH, planar_regressor, torque, white_noise


@pytest.fixture
def data():
    rng = np.random.default_rng(3)
    W = planar_regressor(rng, 300)
    return W, torque(W, white_noise(rng, 300))


def relative(a, b):
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


def streamed(W, y, noise=None, block=64):
    stream = StreamingLeastSquares(W.shape[1], 2)
    for start in range(0, len(y), block):
        rows = noise[start : start + block] if noise is not None and len(noise) == len(y) else noise
        stream.add(W[start : start + block], y[start : start + block], rows)
    return stream


def exact_solution(W, y):
    """Least squares in rational arithmetic: the entries are taken as the exact doubles they are."""
    rows = [[Fraction(x) for x in row] for row in W.tolist()]
    right = [Fraction(x) for x in y.tolist()]
    p, zero = W.shape[1], Fraction(0)
    system = [
        [sum((r[i] * r[j] for r in rows), zero) for j in range(p)]
        + [sum((r[i] * b for r, b in zip(rows, right, strict=True)), zero)]
        for i in range(p)
    ]
    for i in range(p):
        pivot = next(k for k in range(i, p) if system[k][i] != 0)
        system[i], system[pivot] = system[pivot], system[i]
        for k in range(p):
            if k != i:
                ratio = system[k][i] / system[i][i]
                system[k] = [a - ratio * b for a, b in zip(system[k], system[i], strict=True)]
    return np.array([float(system[i][p] / system[i][i]) for i in range(p)])


def test_agrees_with_numpy_without_weights(data):
    W, y = data
    truth = np.linalg.lstsq(W, y, rcond=None)[0]
    found = batch_least_squares(W, y, 2)
    assert relative(found.parameters, truth) < 1e-12
    assert relative(found.covariance, np.linalg.inv(W.T @ W)) < 1e-10
    assert found.squares.sum() == pytest.approx(np.sum((y - W @ truth) ** 2), rel=1e-12)


def test_is_equations_7_and_8(data):
    W, y = data
    rng = np.random.default_rng(0)
    root = rng.standard_normal((8, 8))
    R_xi, mean = root @ root.T + np.eye(8), rng.standard_normal(8)
    R_v = np.diag(np.tile(DEVIATIONS**2, 300))
    P = np.linalg.inv(np.linalg.inv(R_xi) + W.T @ np.linalg.inv(R_v) @ W)
    xi = mean + P @ W.T @ np.linalg.inv(R_v) @ (y - W @ mean)
    found = batch_least_squares(W, y, 2, noise=DEVIATIONS**2, prior=Prior.gaussian(mean, R_xi))
    assert relative(found.parameters, xi) < 1e-11
    assert relative(found.covariance, P) < 1e-10
    information = found.information_factor.T @ found.information_factor
    assert relative(information, W.T @ np.linalg.inv(R_v) @ W) < 1e-12
    assert np.array_equal(found.information_factor, np.triu(found.information_factor))


def test_weighs_with_a_joint_covariance(data):
    W, y = data
    joint = np.array([[1.0, 0.4], [0.4, 0.3]])
    weight = np.kron(np.eye(300), np.linalg.inv(joint))
    truth = np.linalg.solve(W.T @ weight @ W, W.T @ weight @ y)
    assert relative(batch_least_squares(W, y, 2, noise=joint).parameters, truth) < 1e-10


def random_prior():
    rng = np.random.default_rng(8)
    root = rng.standard_normal((8, 8))
    return Prior.gaussian(TRUTH + rng.standard_normal(8), root @ root.T + np.eye(8))


@pytest.mark.parametrize("prior", [None, random_prior()], ids=["flat", "prior"])
@pytest.mark.parametrize("noise", ["none", "joints", "rows", "covariance"])
def test_batch_recursive_and_streaming_are_equal(data, noise, prior):
    W, y = data
    R_v = {
        "none": None,
        "joints": DEVIATIONS**2,
        "rows": np.random.default_rng(2).uniform(0.1, 3.0, len(y)),
        "covariance": np.array([[1.0, 0.4], [0.4, 0.3]]),
    }[noise]
    batch = batch_least_squares(W, y, 2, noise=R_v, prior=prior)
    forms = [
        recursive_least_squares(W, y, 2, noise=R_v, prior=prior).solution,
        recursive_least_squares(W, y, 2, noise=R_v, prior=prior, block=7).solution,
        streamed(W, y, R_v).solve(prior=prior),
        streamed(W, y, R_v, block=2).solve(prior=prior),
    ]
    for form in forms:
        assert relative(form.parameters, batch.parameters) < 1e-9
        assert relative(form.covariance, batch.covariance) < 1e-9
        assert relative(form.information_factor, batch.information_factor) < 1e-9
        assert relative(form.squares, batch.squares) < 1e-9
        assert form.rows == batch.rows


def test_a_strong_prior_wins_and_a_weak_one_vanishes(data):
    W, y = data
    plain = batch_least_squares(W, y, 2).parameters
    weak = Prior.independent(TRUTH + 1, np.full(8, 1e8))
    strong = Prior.independent(TRUTH + 1, np.full(8, 1e-8))
    assert relative(batch_least_squares(W, y, 2, prior=weak).parameters, plain) < 1e-9
    assert relative(batch_least_squares(W, y, 2, prior=strong).parameters, TRUTH + 1) < 1e-9


def test_independent_deviations_are_a_diagonal_covariance():
    std = np.array([0.1, 2.0, 30.0])
    given = Prior.independent(np.arange(3.0), std)
    np.testing.assert_allclose(given.factor.T @ given.factor, np.diag(1 / std**2))
    np.testing.assert_allclose(given.factor.T @ given.offset, np.arange(3.0) / std**2)


def test_an_infinite_prior_deviation_is_no_prior(data):
    W, y = data
    partly = Prior.independent(np.zeros(8), np.where(np.arange(8) == 2, 1e-9, np.inf))
    found = batch_least_squares(W, y, 2, prior=partly).parameters
    others = np.delete(np.arange(8), 2)
    without = np.linalg.lstsq(W[:, others], y, rcond=None)[0]
    assert abs(found[2]) < 1e-9
    assert relative(found[others], without) < 1e-9


@pytest.mark.parametrize("condition", [1e6, 1e8])
def test_keeps_its_digits_where_normal_equations_lose_them(condition):
    rng = np.random.default_rng(5)
    U, _ = np.linalg.qr(rng.standard_normal((40, 6)))
    V, _ = np.linalg.qr(rng.standard_normal((6, 6)))
    W = U @ np.diag(np.geomspace(1, 1 / condition, 6)) @ V
    y = W @ rng.standard_normal(6) + 1e-12 * rng.standard_normal(40)
    truth = exact_solution(W, y)
    forms = [
        batch_least_squares(W, y, 2),
        recursive_least_squares(W, y, 2).solution,
        streamed(W, y, block=10).solve(),
    ]
    allowed = 100 * condition * np.finfo(float).eps
    for form in forms:
        assert relative(form.parameters, truth) < allowed
    normal = np.linalg.solve(W.T @ W, W.T @ y)
    assert relative(normal, truth) > 10 * allowed


def test_units_do_not_change_the_estimate(data):
    W, y = data
    scale = np.geomspace(1e-9, 1e9, 8)
    found = batch_least_squares(W * scale, y, 2)
    plain = batch_least_squares(W, y, 2)
    assert np.allclose(found.parameters * scale, plain.parameters, rtol=1e-10)
    assert np.allclose(found.covariance * np.outer(scale, scale), plain.covariance, rtol=1e-8)


def test_refuses_a_dependent_column_with_evidence(data):
    W, y = data
    with pytest.raises(NotIdentifiable) as refusal:
        batch_least_squares(np.column_stack([W, W[:, 0] - 2 * W[:, 1]]), y, 2)
    assert refusal.value.singular_values[-1] < 1e-12
    assert np.flatnonzero(np.abs(refusal.value.direction) > 1e-6).tolist() == [0, 1, 8]


def test_refuses_what_does_not_fit_together(data):
    W, y = data
    with pytest.raises(ValueError, match="600 regressor rows, but 599"):
        check_stack(W, y[:-1], 2)
    with pytest.raises(ValueError, match="not a multiple of 7"):
        batch_least_squares(W, y, 7)
    with pytest.raises(ValueError, match="not finite"):
        batch_least_squares(W, np.where(np.arange(600) == 5, np.nan, y), 2)
    with pytest.raises(ValueError, match="positive"):
        batch_least_squares(W, y, 2, noise=np.array([1.0, 0.0]))


def test_does_not_write_into_its_arguments(data):
    W, y = data
    before = W.copy(), y.copy()
    batch_least_squares(W, y, 2)
    recursive_least_squares(W, y, 2)
    streamed(W, y).solve()
    assert np.array_equal(W, before[0])
    assert np.array_equal(y, before[1])
