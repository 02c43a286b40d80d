import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from oed.estimation.feasible.coordinates import BASIS, Coordinates, adjoint
from oed.robot.inertia import transform_parameters
from tests.estimation.feasible.cases import random_body


def bodies(rng, links=3):
    return np.concatenate([random_body(rng) for _ in range(links)])


def test_basis_is_orthonormal():
    assert np.allclose(np.einsum("kij,lij->kl", BASIS, BASIS), np.eye(10))


def test_the_reference_is_the_identity():
    rng = np.random.default_rng(1)
    coordinates = Coordinates.relative_to(bodies(rng), np.ones(2))
    assert np.allclose(coordinates.relative_inertias(coordinates.start), np.eye(4))
    assert np.allclose(coordinates.parameters(coordinates.start)[:30], coordinates.reference)


def test_unknowns_invert_parameters():
    rng = np.random.default_rng(2)
    coordinates = Coordinates.relative_to(bodies(rng), np.array([1e-3, 40.0]))
    x = rng.normal(size=32)
    assert np.allclose(coordinates.unknowns(coordinates.parameters(x)), x)


def test_relative_eigenvalues_do_not_depend_on_the_frame():
    rng = np.random.default_rng(3)
    reference, body = random_body(rng), random_body(rng)
    rotation, origin = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)

    def eigenvalues(reference, body):
        coordinates = Coordinates.relative_to(reference, np.zeros(0))
        return np.linalg.eigvalsh(coordinates.relative_inertias(coordinates.unknowns(body))[0])

    moved = [transform_parameters(p, rotation, origin) for p in (reference, body)]
    assert np.allclose(eigenvalues(reference, body), eigenvalues(*moved), rtol=1e-9)


def test_adjoint_is_the_gradient():
    rng = np.random.default_rng(4)
    coordinates = Coordinates.relative_to(bodies(rng, 2), np.zeros(0))
    x, matrices = rng.normal(size=20), rng.normal(size=(2, 4, 4))
    symmetric = matrices + matrices.transpose(0, 2, 1)
    expected = np.sum(symmetric * coordinates.relative_inertias(x))
    assert adjoint(symmetric) @ x == pytest.approx(expected)


def test_refuses_a_reference_that_is_no_body():
    with pytest.raises(ValueError, match="link 2 is not physically consistent"):
        Coordinates.relative_to(
            np.concatenate([random_body(np.random.default_rng(5)), np.zeros(10)]), np.zeros(0)
        )
