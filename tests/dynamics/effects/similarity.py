"""How alike two effects are on a motion, once the model has absorbed what it can of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel

# A residual column shorter than this fraction of the column is what rounding leaves.
ABSORBED = 1e-7
# Singular values of normalised columns below this say that the columns repeat each other.
REPEATED = 1e-8


@dataclass(frozen=True)
class Similarity:
    """Principal angles between what two effects add to a base model.

    Attributes:
        angles: (k,) from the smallest up [rad], k the smaller number of columns that are
            left; empty if the base model absorbs one of the two altogether.
        left: For each effect the largest share of a column that the base does not absorb.
    """

    angles: Float[ndarray, " columns"]
    left: tuple[float, float]

    @property
    def largest(self) -> float:
        """Largest principal angle [rad]: near zero if the smaller effect lies in the other."""
        return float(self.angles[-1]) if len(self.angles) else np.pi / 2


def effect_angles(
    model: TorqueModel,
    first: Effect,
    second: Effect,
    motions: Sequence[Motion],
    noise: Float[ndarray, " joints"],
) -> Similarity:
    """Principal angles between two effects on recordings, modulo a model's own columns.

    Args:
        model: The base model.
        first: One effect.
        second: The other.
        motions: One a recording, evaluated one at a time.
        noise: Standard deviation of the torque noise of each joint [N m].
    """
    n = model.robot.n

    def rows(columns: Float[ndarray, "samples joints columns"]) -> Float[ndarray, "rows columns"]:
        return (columns / noise[:, None]).reshape(-1, columns.shape[2])

    base, one, other = (
        np.concatenate([rows(columns(motion)) for motion in motions])
        for columns in (
            model.columns,
            lambda motion: evaluate(first, motion, n),
            lambda motion: evaluate(second, motion, n),
        )
    )
    return principal_angles(base, one, other)


def principal_angles(
    base: Float[ndarray, "rows base"],
    first: Float[ndarray, "rows first"],
    second: Float[ndarray, "rows second"],
) -> Similarity:
    """Principal angles between two sets of columns modulo a third (Bjorck and Golub 1973).

    Weight the rows by the noise of each joint first: an angle has a meaning only where all
    rows are known equally well.

    Args:
        base: Columns that both are fitted together with; may be rank deficient.
        first: Columns of one effect.
        second: Columns of the other.
    """
    q_base = _orthonormal(_normalised(base))
    parts = [_remainder(q_base, columns) for columns in (first, second)]
    left = (_largest_share(parts[0]), _largest_share(parts[1]))
    q_first, q_second = (_orthonormal(part) for part in parts)
    cosines = np.linalg.svd(q_first.T @ q_second, compute_uv=False)
    # Small angles by their sine, which does not round to zero as their cosine rounds to one.
    smaller, other = sorted((q_first, q_second), key=lambda q: q.shape[1])
    sines = np.linalg.svd(smaller - other @ (other.T @ smaller), compute_uv=False)[::-1]
    angles = np.where(
        cosines < np.sqrt(0.5),
        np.arccos(np.clip(cosines, 0.0, 1.0)),
        np.arcsin(np.clip(sines, 0.0, 1.0)),
    )
    return Similarity(angles, left)


def equivalence_classes(
    base: Float[ndarray, "rows base"],
    effects: Mapping[str, Float[ndarray, "rows _"]],
    angle: float,
) -> tuple[tuple[str, ...], ...]:
    """Effects that a motion cannot tell apart, in the order given.

    Two belong together if they leave equally many columns and the largest principal angle
    between them is below `angle`; classes are joined along chains.

    Args:
        base: Columns of the base model, rows weighted by the noise.
        effects: Columns of each effect by name, rows weighted alike.
        angle: [rad].
    """
    names = list(effects)
    leader = {name: name for name in names}
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            likeness = principal_angles(base, effects[first], effects[second])
            if _same_span(likeness, base, effects[first], effects[second], angle):
                old, new = leader[second], leader[first]
                leader = {name: new if top == old else top for name, top in leader.items()}
    return _grouped(names, leader)


def _grouped(names: Sequence[str], leader: Mapping[str, str]) -> tuple[tuple[str, ...], ...]:
    tops = list(dict.fromkeys(leader[name] for name in names))
    return tuple(tuple(name for name in names if leader[name] == top) for top in tops)


def _same_span(
    likeness: Similarity,
    base: Float[ndarray, "rows base"],
    first: Float[ndarray, "rows first"],
    second: Float[ndarray, "rows second"],
    angle: float,
) -> bool:
    if not len(likeness.angles) or likeness.largest > angle:
        return False
    q_base = _orthonormal(_normalised(base))
    ranks = {_orthonormal(_remainder(q_base, part)).shape[1] for part in (first, second)}
    return len(ranks) == 1


def _remainder(
    q_base: Float[ndarray, "rows base"], columns: Float[ndarray, "rows columns"]
) -> Float[ndarray, "rows columns"]:
    """Normalised columns less what the base absorbs; zero where that is all but rounding."""
    rest = _normalised(columns)
    for _ in range(2):  # once more, against the rounding of the first projection
        rest = rest - q_base @ (q_base.T @ rest)
    rest[:, np.linalg.norm(rest, axis=0) < ABSORBED] = 0.0
    return rest


def _largest_share(rest: Float[ndarray, "rows columns"]) -> float:
    return float(np.linalg.norm(rest, axis=0).max(initial=0.0))


def _normalised(columns: Float[ndarray, "rows columns"]) -> Float[ndarray, "rows columns"]:
    norms = np.linalg.norm(columns, axis=0)
    return columns / np.where(norms > 0, norms, 1.0)


def _orthonormal(columns: Float[ndarray, "rows columns"]) -> Float[ndarray, "rows rank"]:
    left, singular_values, _ = np.linalg.svd(_normalised(columns), full_matrices=False)
    if not len(singular_values):
        return left
    return left[:, singular_values > REPEATED * max(singular_values[0], 1.0)]
