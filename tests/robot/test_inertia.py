"""Standard parameters and pseudo-inertia."""

import numpy as np
import pytest

from oed.robot import imi_scara, parameters_from_pseudo_inertia, pseudo_inertia
from oed.robot.inertia import transform_parameters


def _cloud(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return rng.uniform(0.1, 1.0, 20), rng.normal(size=(20, 3))


def _parameters(masses: np.ndarray, points: np.ndarray) -> np.ndarray:
    parts = (m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    inertia = sum(parts, np.zeros((3, 3)))
    return np.concatenate([[masses.sum()], masses @ points, inertia[np.triu_indices(3)]])


def test_pseudo_inertia_is_the_second_moment_of_the_mass() -> None:
    masses, points = _cloud(np.random.default_rng(1))
    homogeneous = np.column_stack([points, np.ones(len(points))])
    expected = homogeneous.T @ (masses[:, None] * homogeneous)
    assert pseudo_inertia(_parameters(masses, points)) == pytest.approx(expected)


def test_round_trip() -> None:
    parameters = _parameters(*_cloud(np.random.default_rng(2)))
    assert parameters_from_pseudo_inertia(pseudo_inertia(parameters)) == pytest.approx(parameters)


def test_a_moved_frame_sees_the_moved_points() -> None:
    rng = np.random.default_rng(3)
    masses, points = _cloud(rng)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    origin = rng.normal(size=3)
    moved = transform_parameters(_parameters(masses, points), rotation, origin)
    assert moved == pytest.approx(_parameters(masses, points @ rotation.T + origin))


def test_the_scara_is_physically_consistent() -> None:
    for link in imi_scara().parameters.reshape(2, 10):
        assert np.linalg.eigvalsh(pseudo_inertia(link)).min() > 0
