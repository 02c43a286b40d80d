import numpy as np
import pytest

from oed.estimation.streaming import StreamingLeastSquares
from tests.estimation.planar_arm import planar_regressor, torque, white_noise


@pytest.fixture
def data():
    rng = np.random.default_rng(3)
    W = planar_regressor(rng, 500)
    return W, torque(W, white_noise(rng, 500))


def stream_of(W, y):
    stream = StreamingLeastSquares(8, 2)
    stream.add(W, y)
    return stream


def test_knows_the_residual_of_each_joint_at_any_parameters(data):
    W, y = data
    anywhere = np.arange(8.0)
    squares = np.sum((y - W @ anywhere).reshape(-1, 2) ** 2, axis=0)
    assert np.allclose(stream_of(W, y).squares(anywhere), squares, rtol=1e-12)


def test_finds_the_joint_variances_without_another_pass(data):
    # Their equation, written out: s_j = |r_j|^2 / (N - trace of the joint's block of the hat matrix).
    W, y = data
    _, variances = stream_of(W, y).solve_with_residual_variances(tolerance=1e-12)
    white = W / np.tile(np.sqrt(variances), 500)[:, None]
    information = np.linalg.inv(white.T @ white)
    parameters = information @ white.T @ (y / np.tile(np.sqrt(variances), 500))
    squares = np.sum((y - W @ parameters).reshape(-1, 2) ** 2, axis=0)
    shares = np.sum((white @ information * white).sum(axis=1).reshape(-1, 2), axis=0)
    np.testing.assert_allclose(variances, squares / (500 - shares), rtol=1e-9)


def test_keeps_the_same_memory_whatever_it_has_seen(data):
    W, y = data
    stream = StreamingLeastSquares(8, 2)
    sizes = set()
    for _ in range(20):
        stream.add(W, y)
        sizes.add(sum(v.nbytes for v in vars(stream).values() if isinstance(v, np.ndarray)))
    assert sizes == {2 * 9 * 9 * 8}
    assert stream.rows == 20_000


def test_a_refused_block_leaves_no_trace(data):
    W, y = data
    stream = stream_of(W, y)
    before = stream.solve()
    with pytest.raises(ValueError, match="not finite"):
        stream.add(W, np.full_like(y, np.inf))
    with pytest.raises(ValueError, match="7 columns, but 8"):
        stream.add(W[:, :7], y)
    assert np.array_equal(stream.solve().parameters, before.parameters)
    assert stream.rows == before.rows
