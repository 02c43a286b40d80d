"""Where a camera stands for what it shows to fill the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

FIELD_OF_VIEW = 40.0  # [deg] of the picture's height: about that of a photographer's normal lens
FILLED = 0.95  # share of the picture's height or width, whichever is full first
# Directions that are tried: from above the floor, and never so steeply that heights are lost.
ELEVATIONS = np.radians([20.0, 35.0, 50.0])
ASPECTS = np.linspace(1.0, 16 / 9, 15)  # of pictures: from a square to a screen
AZIMUTHS = np.radians(np.arange(0.0, 360.0, 30.0))


@dataclass(frozen=True)
class Camera:
    """A camera that holds the z axis upright.

    Attributes:
        position: (3,) where it stands [m].
        target: (3,) the middle of its picture [m].
        aspect: Width of its picture over the height.
    """

    position: Float[ndarray, "3"]
    target: Float[ndarray, "3"]
    aspect: float


def framing(points: Float[ndarray, "points 3"]) -> Camera:
    """The camera that shows all points as large as the picture allows, which takes their shape.

    Of the directions that are tried, that from which the points spread over the largest area: where
    least of their extent is hidden in the depth.

    Args:
        points: (P, 3) what must be seen [m], not all in one place.
    """
    directions = [
        np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        for e in ELEVATIONS
        for a in AZIMUTHS
    ]
    toward = max(
        directions, key=lambda d: np.ptp(points @ np.stack(_axes(d), axis=1), axis=0).prod()
    )
    aspect = min(ASPECTS, key=lambda a: np.ptp(_distances(points, toward, a)[0]))
    distances, target = _distances(points, toward, aspect)
    return Camera(target + distances.max() * toward, target, float(aspect))


def half_height() -> float:
    """Tangent of half the angle that the picture's height spans."""
    return float(np.tan(np.radians(FIELD_OF_VIEW / 2)))


def _axes(toward: Float[ndarray, "3"]) -> tuple[Float[ndarray, "3"], Float[ndarray, "3"]]:
    """What points right and what points up in a picture that is taken from a direction."""
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    return right, np.cross(toward, right)


def _distances(
    points: Float[ndarray, "points 3"], toward: Float[ndarray, "3"], aspect: float
) -> tuple[Float[ndarray, "2"], Float[ndarray, "3"]]:
    """How far off a camera in a direction sees all points across and upwards, and its target [m].

    A point at height z above the target, toward the camera at distance D, is inside if
    |x - c| <= (D - z) s, with s the slope of the picture's edge: of all points, the largest x + s z and the
    least x - s z bind, so that c is their mean and D s half of what lies between them.
    """
    z = points @ toward
    slope = FILLED * half_height()
    target, distances = np.zeros(3), np.zeros(2)
    for k, (axis, edge) in enumerate(zip(_axes(toward), (aspect * slope, slope), strict=True)):
        along = points @ axis
        high, low = (along + edge * z).max(), (along - edge * z).min()
        target += (high + low) / 2 * axis
        distances[k] = (high - low) / (2 * edge)
    return distances, target
