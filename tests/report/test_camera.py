"""A camera sees everything, and no nearer one would."""

import numpy as np
import pytest
from numpy import ndarray

from oed.report.camera import FILLED, framing, half_height


def seen(points: ndarray) -> ndarray:
    """(P, 2) where each point is in the picture: 1 at its right and upper edge, -1 at the others."""
    camera = framing(points)
    toward = camera.position - camera.target
    toward /= np.linalg.norm(toward)
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    offset = points - camera.position
    depth = -offset @ toward
    assert (depth > 0).all()
    edge = half_height() * depth
    return np.stack(
        [offset @ right / (camera.aspect * edge), offset @ np.cross(toward, right) / edge], 1
    )


@pytest.mark.parametrize("size", [(1.0, 1.0, 1.0), (2.0, 0.1, 0.1), (0.1, 0.2, 3.0), (1, 1, 0)])
def test_what_is_shown_fills_the_picture(size: tuple[float, ...]) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (200, 3)) * size + (3.0, -2.0, 0.5)
    placed = seen(points)
    assert np.abs(placed).max() == pytest.approx(FILLED)
    low, high = placed.min(axis=0), placed.max(axis=0)
    # One direction is filled from edge to edge, so that no nearer camera sees all.
    assert (high - low).max() == pytest.approx(2 * FILLED)


def test_a_flat_motion_is_seen_from_as_far_above_as_is_tried_and_a_long_one_from_its_side() -> None:
    flat = framing(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]))
    toward = flat.position - flat.target
    assert np.arcsin(toward[2] / np.linalg.norm(toward)) == pytest.approx(np.radians(50))
    long = framing(np.array([[0, 0, 0], [9, 0, 0], [9, 0.1, 1], [0, 0.1, 1]]))
    toward = (long.position - long.target)[:2]
    assert abs(toward[0]) / np.linalg.norm(toward) < 0.6


def test_the_picture_has_the_shape_of_what_is_shown() -> None:
    ball = np.random.default_rng(0).normal(size=(2000, 3))
    placed = seen(ball / np.linalg.norm(ball, axis=1)[:, None])
    assert np.ptp(placed, axis=0).min() > 0.95 * 2 * FILLED
    assert framing(ball * (9, 1, 1)).aspect == pytest.approx(16 / 9)
