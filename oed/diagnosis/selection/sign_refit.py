"""How sharply friction turns where a joint reverses: a shape of the base model, refitted beside the rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.fit import Projection
from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.evidence.views import Views, Which
from oed.diagnosis.numbers import PREDICTION_GAIN
from oed.diagnosis.problem import Problem
from oed.dynamics.effects import Coulomb
from oed.dynamics.velocity_sign import sign_terms, signs_of, with_signs
from oed.estimation.noise_floor.sign_width import Turn, gain_beside


def with_refitted_sign(views: Views, which: Which, joints: Collection[int] | None = None) -> Views:
    """The model whose base's signs turn over the velocities that fit best beside all its terms.

    Args:
        views: A model; its means show a sign's turn best.
        which: Rows that are fitted.
        joints: Of which; all if None.
    """
    problem, means = views.problem, views.means
    sharpest = signs_of(problem.sharpest)
    found = {
        sign.joint: _best_turn(means, int(own[0]), sign, sharpest[sign.joint])
        for _, column, sign in sign_terms(problem.base)
        if joints is None or sign.joint in joints
        if len(own := np.flatnonzero(means.columns == column))
    }
    base = with_signs(problem.base, found)
    if base == problem.base:
        return views

    def turned(own: Problem) -> Problem:
        return dataclasses.replace(
            own, base=base, context=dataclasses.replace(own.context, model=base)
        )

    again = turned(problem)
    if problem.means is not None:
        again = dataclasses.replace(again, means=turned(problem.means))
    sharper = Views.of(again, views.terms, which, views)
    return sharper if sharper.rise(views, which) > PREDICTION_GAIN else views


def _best_turn(fitted: Fitted, number: int, sign: Coulomb, sharpest: Coulomb) -> Coulomb:
    """The friction of a column of a fit, with the turn that gains most beside all other columns.

    It stays as it is where the rows tell it from the best by less than a parameter costs. A lag
    moves where friction turns: it is seen through what is installed.
    """
    joint, own = sign.joint, fitted.projection
    without = _Without(own, number, joint)
    alone = dataclasses.replace(fitted.installed, effects=(sharpest,))
    counted = float(fitted.rows(own.used)[joint])
    turn = Turn(alone, fitted.problem.rows.rows, without.gain, without.squares, counted)
    best = turn.best(sharpest)
    gained = (turn.gain_of(best) - turn.gain_of(sign)) / (2 * float(fitted.variance[joint]))
    return best if gained > PREDICTION_GAIN else sign


@dataclasses.dataclass(frozen=True, eq=False)
class _Without:
    """A fit without one of its columns: its span less one direction."""

    projection: Projection
    number: int
    joint: int

    @cached_property
    def _direction(self) -> tuple[Float[ndarray, " rank"], float]:
        """Of the column beside all others in the basis, and the torque's share of it."""
        own = self.projection.inverse[self.number]
        length = float(np.linalg.norm(own))
        return own / length, float(self.projection.coefficients[self.number]) / length

    @property
    def squares(self) -> float:
        """Sum of squares that the others leave of the joint's white rows."""
        direction, size = self._direction
        own = self.projection.basis[self.joint] @ direction * size
        left = self.projection.span.left[self.joint] + own
        return float(np.sum(left**2)) / self.projection.weights[self.joint] ** 2

    def gain(self, column: Float[ndarray, " rows"]) -> float:
        """Fall of the sum of squares of white rows by another column of the joint."""
        weight = self.projection.weights[self.joint]
        own = column[self.projection.used] * weight
        direction, size = self._direction
        inside = self.projection.basis[self.joint].T @ own
        along = float(inside @ direction)
        moment = float(own @ self.projection.span.left[self.joint]) + along * size
        return gain_beside(float(own @ own), float(inside @ inside) - along**2, moment) / weight**2
