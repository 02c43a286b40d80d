"""Where bodies and joints are in one posture, and how fast their points move."""

from __future__ import annotations

from dataclasses import dataclass

from jaxtyping import Float
from numpy import ndarray


@dataclass(frozen=True)
class Poses:
    """Where the bodies that a joint moves and the joints are in one posture, in the world.

    Attributes:
        rotation: (bodies, 3, 3) of each body's frame; 0 of those that nothing moves.
        origin: (bodies, 3) of each body's frame [m]; likewise.
        axes: (n, 3) of each joint.
        moments: (n, 3) velocity that each joint gives a point at 0: a point p that joint j moves
            has the velocity axis_j x p + moment_j per unit of it.
    """

    rotation: Float[ndarray, "bodies 3 3"]
    origin: Float[ndarray, "bodies 3"]
    axes: Float[ndarray, "joints 3"]
    moments: Float[ndarray, "joints 3"]

    def rates(
        self, points: Float[ndarray, "points 3"], directions: Float[ndarray, "points 3"]
    ) -> Float[ndarray, "points joints"]:
        """Speed of each point along its direction, per unit of each joint that moves it."""
        return cross_rows(points, directions) @ self.axes.T + directions @ self.moments.T


def cross_rows(a: Float[ndarray, "k 3"], b: Float[ndarray, "k 3"]) -> Float[ndarray, "k 3"]:
    """NumPy's cross product, which spends its time on the shapes of so few vectors."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
