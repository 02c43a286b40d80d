"""A regressor in pieces gives what the whole one gives, and no more of it is held than is said."""

import numpy as np
import pytest

from oed.estimation.identify import identify
from oed.estimation.recursive import recursive_least_squares
from oed.estimation.row_pieces import PIECE_BYTES, RowPieces, even_pieces
from tests.estimation.planar_arm import (
    DEVIATIONS,
    NAMES,
    UNITS,
    autoregressive_noise,
    planar_regressor,
    torque,
)

LENGTHS = (150, 90, 160)


@pytest.fixture
def data():
    rng = np.random.default_rng(8)
    W = planar_regressor(rng, sum(LENGTHS))
    return W, torque(W, 0.1 * autoregressive_noise(rng, sum(LENGTHS), 0.6)).reshape(-1, 2)


class Evaluated:
    """A regressor's pieces as a model would evaluate them, with a count of how often."""

    def __init__(self, regressor, lengths):
        pieces = np.split(regressor, 2 * np.cumsum(lengths)[:-1])
        self.times = [0] * len(pieces)
        evaluate = tuple(self._of(number, piece) for number, piece in enumerate(pieces))
        self.rows = RowPieces(evaluate, lengths, 2, regressor.shape[1])

    def _of(self, number, piece):
        def evaluate():
            self.times[number] += 1
            return piece.copy()

        return evaluate


@pytest.mark.parametrize("robust", [None, "huber"])
def test_an_estimate_in_pieces_is_that_of_the_whole(data, robust):
    W, tau = data
    rng = np.random.default_rng(1)
    certainty = rng.uniform(0.2, 1.0, tau.shape)
    other = planar_regressor(rng, 70)
    arguments = {"robust": robust, "certainty": certainty}
    rows = Evaluated(W, LENGTHS).rows
    pieces = identify(rows, tau, NAMES, UNITS, others=(Evaluated(other, (70,)).rows,), **arguments)
    whole = identify(W, tau, NAMES, UNITS, others=(other,), segments=LENGTHS, **arguments)
    for name in ("parameters", "covariance", "residual", "joint_variances", "reach"):
        np.testing.assert_allclose(
            getattr(pieces, name), getattr(whole, name), rtol=1e-8, atol=1e-12
        )
    np.testing.assert_allclose(
        pieces.effective_degrees_of_freedom, whole.effective_degrees_of_freedom, rtol=1e-8
    )
    assert (pieces.method, pieces.degrees_of_freedom) == (whole.method, whole.degrees_of_freedom)


def test_one_piece_or_many_solve_the_normal_equations(data):
    W, tau = data
    weights = np.tile(1 / DEVIATIONS**2, len(tau))
    expected = np.linalg.solve(W.T * weights @ W, W.T @ (weights * tau.reshape(-1)))
    for lengths in (LENGTHS, (len(tau),), (3,) * 130 + (10,)):
        found = identify(
            Evaluated(W, lengths).rows, tau, NAMES, UNITS, noise=DEVIATIONS**2, covariance="white"
        )
        np.testing.assert_allclose(found.parameters, expected, rtol=1e-9)
        left = tau - (W @ expected).reshape(-1, 2)
        np.testing.assert_allclose(found.residual, left, atol=1e-10)


def test_the_history_does_not_see_the_pieces(data):
    W, tau = data
    whole = recursive_least_squares(W, tau.reshape(-1), 2, block=14)
    pieces = recursive_least_squares(Evaluated(W, LENGTHS).rows, tau.reshape(-1), 2, block=14)
    np.testing.assert_array_equal(pieces.rows, whole.rows)
    np.testing.assert_allclose(pieces.parameters, whole.parameters, rtol=1e-8)
    np.testing.assert_allclose(pieces.std, whole.std, rtol=1e-8)


def test_pieces_are_held_as_far_as_the_bytes_reach(data):
    W, _ = data
    counted = Evaluated(W, LENGTHS)
    held = counted.rows.held(W[: 2 * (150 + 90)].nbytes)
    for _ in range(3):
        np.testing.assert_array_equal(np.concatenate(list(held)), W)
    assert counted.times == [1, 1, 3]


def test_long_recordings_are_cut_into_even_pieces():
    samples, joints, columns = 200_001, 7, 57
    pieces = even_pieces(samples, joints, columns)
    lengths = [piece.stop - piece.start for piece in pieces]
    assert sum(lengths) == samples
    assert pieces[0].start == 0
    assert max(lengths) - min(lengths) <= 1
    assert max(lengths) * joints * columns * 8 <= 1.001 * PIECE_BYTES
    assert even_pieces(1000, joints, columns) == (slice(0, 1000),)
