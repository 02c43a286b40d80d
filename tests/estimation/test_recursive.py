import numpy as np

from oed.estimation.least_squares import batch_least_squares
from oed.estimation.prior import Prior
from oed.estimation.recursive import recursive_least_squares
from tests.estimation.planar_arm import TRUTH, planar_regressor, torque, white_noise


def test_follows_the_papers_recursion_row_by_row():
    rng = np.random.default_rng(1)
    W = planar_regressor(rng, 40)
    y = torque(W, white_noise(rng, 40))
    xi, P = np.zeros(8), 4.0 * np.eye(8)
    found = recursive_least_squares(W, y, 2, prior=Prior.gaussian(xi, P))
    for step, (h, torque_now) in enumerate(zip(W, y, strict=True)):
        K = P @ h / (1 + h @ P @ h)
        xi = xi + K * (torque_now - h @ xi)
        P = P - np.outer(K, h @ P)
        assert np.allclose(found.parameters[step], xi, rtol=1e-8, atol=1e-9)
        assert np.allclose(found.std[step], np.sqrt(np.diag(P)), rtol=1e-8)


def test_every_step_is_the_batch_solution_of_its_rows():
    rng = np.random.default_rng(1)
    W = planar_regressor(rng, 60)
    y = torque(W, white_noise(rng, 60))
    found = recursive_least_squares(W, y, 2, block=6)
    assert found.rows[-1] == 120
    for rows, parameters in zip(found.rows, found.parameters, strict=True):
        if rows >= 18:
            batch = batch_least_squares(W[:rows], y[:rows], 2)
            assert np.allclose(parameters, batch.parameters, rtol=1e-8)


def test_says_nothing_before_the_rows_determine_all():
    rng = np.random.default_rng(1)
    W = planar_regressor(rng, 60)
    found = recursive_least_squares(W, W @ TRUTH, 2)
    undetermined = np.all(np.isnan(found.parameters), axis=1)
    assert undetermined[:7].all()
    assert not undetermined[-1]
    assert np.isnan(found.std[0]).all()
    assert np.allclose(found.parameters[-1], TRUTH)
