"""How sharply friction turns where a joint reverses: a shape of the base model, refitted beside the rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.evidence.views import Views, Which, chosen
from oed.diagnosis.numbers import PREDICTION_GAIN
from oed.diagnosis.problem import Problem
from oed.dynamics.effects import Coulomb
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import sign_terms, signs_of, with_signs
from oed.estimation.noise_floor.sign_width import Others, Turn
from oed.estimation.sign_width import choose_sign_widths
from oed.experiment.preparation.processed import processed
from oed.parallel_map import parallel_map


def with_refitted_sign(views: Views, which: Which, joints: Collection[int] | None = None) -> Views:
    """The model whose base's signs turn over the velocities that fit best beside all its terms.

    Args:
        views: A model; its means show a sign's turn best.
        which: Rows that are fitted.
        joints: Of which; all if None.
    """
    problem, means = views.problem, views.means
    sharpest = signs_of(problem.sharpest)
    asked = [
        (int(own[0]), sign)
        for _, column, sign in sign_terms(problem.base)
        if joints is None or sign.joint in joints
        if len(own := np.flatnonzero(means.columns == column))
    ]
    means.projection.span  # noqa: B018 shared by all of them
    found = parallel_map(lambda at: _best_turn(means, *at, sharpest[at[1].joint]), asked)
    base = with_signs(problem.base, {sign.joint: sign for sign in found})
    if base == problem.base:
        return views
    sharper = Views.of(_turned(problem, base), views.terms, which, views)
    before, after = (v.means.score(chosen(v.means.problem, which)) for v in (views, sharper))
    return sharper if after - before > PREDICTION_GAIN else views


def with_least_torque_left(views: Views) -> Problem:
    """What is asked, of a base model whose signs turn as `oed identify` chooses them.

    That is over the velocities that leave least of the torque of all rows. What guards the choice of
    terms takes the rows of a reversal for uncertain, and these tell most of how it turns.
    """
    problem, told = views.problem, views.told
    estimation = (p for p in problem.rows.prepared if p.role == "estimation")
    recordings = [piece for p in estimation for piece in processed(p)]
    chosen = choose_sign_widths(told.torque_model, told.columns, recordings)
    return _turned(problem, with_signs(problem.base, signs_of(chosen)))


def _turned(problem: Problem, base: TorqueModel) -> Problem:
    """The same question of a base model with other signs."""

    def turned(own: Problem) -> Problem:
        return dataclasses.replace(
            own, base=base, context=dataclasses.replace(own.context, model=base)
        )

    again = turned(problem)
    if problem.means is None:
        return again
    return dataclasses.replace(again, means=turned(problem.means))


def _best_turn(fitted: Fitted, number: int, sign: Coulomb, sharpest: Coulomb) -> Coulomb:
    """The friction of a column of a fit, with the turn that gains most beside all other columns.

    It stays as it is where the rows tell it from the best by less than a parameter costs. A lag
    moves where friction turns: it is seen through what is installed.
    """
    joint, own, rows = sign.joint, fitted.projection, fitted.problem.rows.rows
    weight, left = float(own.weights[joint]), own.span.left[joint]
    others = Others.of(own.basis[joint], left, own.inverse[number], float(own.coefficients[number]))

    def gain(column: Float[ndarray, " rows"]) -> float:
        return others.gain(column[own.used] * weight) / weight**2

    alone = dataclasses.replace(fitted.installed, effects=(sharpest,))
    counted = float(fitted.rows(own.used)[joint])
    turn = Turn(alone, rows, gain, others.squares / weight**2, counted)
    best = turn.best(sharpest)
    gained = (turn.gain_of(best) - turn.gain_of(sign)) / (2 * float(fitted.variance[joint]))
    return best if gained > PREDICTION_GAIN else sign
