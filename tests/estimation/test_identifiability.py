import numpy as np
import pytest

from oed.estimation.identifiability import badly_excited, find_identifiable
from tests.estimation.planar_arm import NAMES, planar_regressor


@pytest.fixture
def regressor():
    return planar_regressor(np.random.default_rng(0), 100)


def test_keeps_everything_that_is_determined(regressor):
    W = regressor
    found = find_identifiable(W, NAMES)
    assert found.kept == tuple(range(8))
    assert found.names == NAMES
    assert found.removed == ()


def test_names_the_combination_and_all_its_members(regressor):
    W = regressor
    H = np.column_stack([W, 2 * W[:, 0] - 0.5 * W[:, 3]])
    found = find_identifiable(H, (*NAMES, "Ia_1"))
    assert found.removed == ("Izz_1", "Izz_2", "Ia_1")
    assert found.names[0] == "Izz_1 + 2*Ia_1"
    assert found.names[3] == "Izz_2 - 0.5*Ia_1"
    assert found.names[1] == "mx_2"
    assert all("9 singular values" in reason for reason in found.reasons)
    assert found.singular_values[-1] < 1e-12


def test_the_combination_gives_the_same_torque(regressor):
    W = regressor
    H = np.column_stack([W[:, 2] - W[:, 5], W, 2 * W[:, 0] + W[:, 1]])
    xi = np.random.default_rng(1).standard_normal(10)
    found = find_identifiable(H, tuple("abcdefghij"))
    assert np.allclose(H[:, list(found.kept)] @ (found.combination @ xi), H @ xi)


def test_names_a_column_that_nothing_depends_on(regressor):
    W = regressor
    H = W.copy()
    H[:, 6] = 0
    found = find_identifiable(H, NAMES)
    assert found.removed == ("Fc_2",)
    assert "no torque depends on it" in found.reasons[0]


def test_units_do_not_change_what_is_identifiable(regressor):
    W = regressor
    H = np.column_stack([W, W[:, 0] + W[:, 1]])
    names = (*NAMES, "extra")
    scale = np.geomspace(1e-8, 1e8, 9)
    assert find_identifiable(H * scale, names).removed == find_identifiable(H, names).removed
    assert find_identifiable(W * scale[:8], NAMES).removed == ()


def test_names_what_is_badly_excited_and_its_partner():
    rng = np.random.default_rng(2)
    H = rng.standard_normal((300, 3))
    H[:, 2] = H[:, 1] + 1e-3 * H[:, 2]
    R = np.asarray(np.linalg.qr(H, mode="r"))
    covariance = np.linalg.inv(H.T @ H)
    sentences = badly_excited(("a", "b", "c"), np.array([1.0, 2.0, 2.0]), covariance, R)
    assert set(sentences) == {"b", "c"}
    assert "most correlated with c (-1.00)" in sentences["b"]
