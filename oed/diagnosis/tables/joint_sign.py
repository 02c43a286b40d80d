"""A sign that turns over some velocity, and a law of low speed on the same joint, fitted together.

Both bend friction where the joint creeps. Fitted in turn, each settles where the other stands: a
sign that had taken up half of a Stribeck effect before that had a name keeps it, and the effect
comes out several times too large beside it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from oed.diagnosis.tables.workbench import Layout, fit_with
from oed.diagnosis.terms.climbing import climb
from oed.diagnosis.terms.scores import Score, score
from oed.diagnosis.terms.trials import Trial, moved
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.noise.linear_fit import whitened_regressor
from oed.diagnosis_new.noise.sign_width import (
    COMPLETE,
    DECISIVE,
    LARGEST_WIDTH,
    MODEST_WIDTH,
    SMALLEST_WIDTH,
    usual_speed,
)
from oed.dynamics.effects import Coulomb, with_columns
from oed.dynamics.effects.catalogue import CATALOGUE, Context
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import signs_of, with_signs
from oed.parallel_map import side_by_side

LAW_OF_SPEED = "odd in speed"  # family whose shapes trade places with the sign's width
NEARBY = 1.5  # ratio to the widths that tell whether there is a better one at all
POINTS = 7  # widths that are tried over the whole range
SETTLED = 0.05  # of the logarithm of a width


def with_signs_fitted_together(
    baseline: Baseline,
    fitted: TorqueModel,
    layout: Layout,
    chosen: Sequence[Trial],
    context: Context,
) -> TorqueModel:
    """A base model with each sign at the width that it wants together with a law of low speed.

    Args:
        baseline: As the additions stand beside it.
        fitted: Its model with the signs fitted beside additions as they are.
        layout: Rows that show all additions.
        chosen: Additions.
        context: What is known beside them.
    """
    beside = (_sign_beside(baseline.model, trial) for trial in chosen)
    kept = {sign.joint: sign for sign in beside if sign is not None}
    baseline = dataclasses.replace(baseline, model=with_signs(fitted, kept))
    for trial in chosen:
        sign = _sign_beside(baseline.model, trial)
        if sign is not None:
            together = _Together(baseline, layout, tuple(chosen), context, trial, sign)
            baseline = dataclasses.replace(baseline, model=together.best_model())
    return baseline.model


def is_law_of_speed(trial: Trial) -> bool:
    """Whether an addition trades places with the turn of a sign."""
    return not trial.is_free_form and LAW_OF_SPEED in CATALOGUE[trial.name].families


def _sign_beside(model: TorqueModel, trial: Trial) -> Coulomb | None:
    """The sign that trades places with an addition; None if none does."""
    if not is_law_of_speed(trial):
        return None
    return signs_of(model).get(trial.joint) if trial.joint is not None and trial.shapes else None


@dataclass
class _Together:
    """One addition, and the sign that turns beside it.

    Attributes:
        baseline: With the sign.
        layout: Rows that show all additions.
        chosen: All additions.
        context: What is known beside them.
        trial: The addition, at the shape that it has.
        sign: As it is in the baseline.
        best: The addition at the best shape so far; None before the first.
        least: Squares that were left at that shape.
    """

    baseline: Baseline
    layout: Layout
    chosen: tuple[Trial, ...]
    context: Context
    trial: Trial
    sign: Coulomb
    best: Trial | None = None
    least: float = np.inf

    def best_model(self) -> TorqueModel:
        """The base model with the sign at its best width: the sharpest, if no wider is clearly better."""
        usual = usual_speed(self.layout.rows, self.sign.joint)
        sharpest = max(SMALLEST_WIDTH * usual, self._least_width())
        widest = max(LARGEST_WIDTH * usual, sharpest)
        # Below what the encoder tells apart all widths are alike: a better one may be far.
        grid = np.geomspace(sharpest, widest, POINTS)
        nearby = self.sign.width * np.array([1.0, 1 / NEARBY, NEARBY])
        tried = [*grid, *nearby[(nearby >= sharpest) & (nearby <= widest)]]
        left = [self._left(float(width)) for width in tried]
        best = int(np.argmin(left))
        step = max(float(grid[1] / grid[0]), NEARBY)
        found = minimize_scalar(
            lambda x: self._left(float(np.exp(x))),
            bounds=np.log(np.clip([tried[best] / step, tried[best] * step], sharpest, widest)),
            method="bounded",
            options={"xatol": SETTLED},
        )
        width, least = float(np.exp(found.x)), float(found.fun)
        if left[best] < least:
            width, least = float(tried[best]), left[best]
        rows = max(float(self.layout.rows.counted[self.sign.joint]), 1.0)
        noise = max(1.0, least / float(np.sum(self.layout.rows.counted)))
        if left[0] - least < noise * DECISIVE + np.log(rows):
            width = sharpest
        elif noise > COMPLETE and width > MODEST_WIDTH * usual:  # it stands in for something else
            width = self.sign.width
        return self._model(dataclasses.replace(self.sign, width=width))

    def _left(self, width: float) -> float:
        """Squares that are left with a width, the addition at its best shape beside it."""
        sign = dataclasses.replace(self.sign, width=width)
        model = self._model(sign)
        others = [t for t in self.chosen if t.key != self.trial.key]
        baseline = dataclasses.replace(self.baseline, model=model)
        fit = fit_with(baseline, self._layout(sign), others, None).fit
        context = dataclasses.replace(self.context, model=model)
        # From the shape that is best so far, too: each alone may lie on the wrong side of a crest.
        starts = [self.trial] if self.best is None else [self.trial, self.best]

        def climbed(start: Trial) -> Score:
            return climb(score(moved(start, fit.rows, context), fit), fit, context)

        found = max(side_by_side(climbed, starts), key=lambda s: s.gain)
        left = fit.squares - found.gain
        if left < self.least:
            self.least, self.best = left, found.trial
        return left

    def _model(self, sign: Coulomb) -> TorqueModel:
        return with_signs(self.baseline.model, {sign.joint: sign})

    def _layout(self, sign: Coulomb) -> Layout:
        """The layout with the sign's column as it is with this sign."""
        model, columns = self.baseline.model, self.baseline.columns
        alone = dataclasses.replace(model, effects=(sign,))
        column = whitened_regressor(alone, np.zeros(1, dtype=int), self.layout.rows)
        regressor = self.layout.regressor.copy()
        place = next(p for effect, p in with_columns(model.effects) if effect is self.sign)
        regressor[:, :, columns == place.start] = column
        return dataclasses.replace(self.layout, regressor=regressor)

    def _least_width(self) -> float:
        place = list(signs_of(self.baseline.model)).index(self.sign.joint)
        return self.baseline.least_widths[place]
