"""The model's state, one value, and its fit."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.diagnosis.evidence.columns import dense, white_effect, white_model
from oed.diagnosis.evidence.criterion import log_score
from oed.diagnosis.evidence.fit import Projection, project
from oed.diagnosis.evidence.term import Term, install, steps_of
from oed.diagnosis.numbers import BASE_ERROR, FORMULA_ERROR, ROUNDS
from oed.diagnosis.problem import Problem, full_parameters, visible_columns
from oed.dynamics.effects.catalogue import Context
from oed.dynamics.effects.effect import Effect
from oed.dynamics.effects.on_reference import holds_reference
from oed.dynamics.torque_model import TorqueModel

SETTLED = 1e-3  # of a size, below which a step of it is none
# Of a joint's variance: weights that are off by so little cost a ten-thousandth of the information.
SAME_VARIANCE = 0.02
NO_CHANGE = (
    0.1  # sum of squares of a change of all rows, in units of what is left: a twentieth of a nat
)


@dataclass(frozen=True, eq=False)
class Fitted:
    """Terms beside the base model, fitted to rows.

    Attributes:
        problem: What is asked.
        terms: Beside the base model.
        installed: The base model with all terms that act on the whole of it.
        effects: Effect of each term, None of those that have no columns.
        places: Columns of each term in the design.
        projection: The fit.
        variance: (n,) v, the larger of what is left and what is tolerated, in units of noise.
        tolerated: (n,) phi.
        context: The same as the problem's with what was fitted.
        columns: (b,) of the installed model that are estimated.
    """

    problem: Problem
    terms: tuple[Term, ...]
    installed: TorqueModel
    effects: tuple[Effect | None, ...]
    places: tuple[slice, ...]
    projection: Projection
    variance: Float[ndarray, " joints"]
    tolerated: Float[ndarray, " joints"]
    context: Context
    columns: Int[ndarray, " base"]

    @property
    def coefficients(self) -> list[Float[ndarray, " columns"]]:
        """Of each term."""
        return [self.projection.coefficients[place] for place in self.places]

    @property
    def parameters(self) -> Float[ndarray, " parameters"]:
        """Of all columns of the installed model."""
        base = self.projection.coefficients[: len(self.columns)]
        return full_parameters(self.installed, self.columns, base)

    def squares(
        self, where: Bool[ndarray, " rows"], *, is_ahead: bool = False
    ) -> Float[ndarray, " joints"]:
        """(n,) sums of squares of what is left of some rows, in units of noise.

        Args:
            where: Which rows.
            is_ahead: Whether they are predicted: nuisances are part of no prediction.
        """
        left = self.projection.residual[:, where]
        if is_ahead:
            start = len(self.columns)
            own = self.projection.coefficients[start : start + self.problem.nuisances.shape[2]]
            left = left + self.problem.nuisances[:, where] @ own
        return np.sum(left**2, axis=1)

    def rows(self, where: Bool[ndarray, " rows"]) -> Float[ndarray, " joints"]:
        """(n,) how many of them count."""
        return np.maximum(self.problem.rows.counts[:, where].sum(axis=1), 1.0)

    def score(self, where: Bool[ndarray, " rows"], *, is_ahead: bool = False) -> float:
        """Log score of some rows, as in `squares` [nats]."""
        squares = self.squares(where, is_ahead=is_ahead)
        return log_score(squares, self.rows(where), self.tolerated)

    def power(self, place: slice) -> Float[ndarray, " joints"]:
        """(n,) mean square of what columns give, in units of noise."""
        own = self.projection.columns[:, :, place] @ self.projection.coefficients[place]
        return np.sum(own**2, axis=1) / self.problem.rows.counted


def fit(
    problem: Problem,
    terms: tuple[Term, ...],
    used: Bool[ndarray, " rows"],
    before: Fitted | None = None,
    variance: Float[ndarray, " joints"] | None = None,
) -> Fitted:
    """Fit a model, effects of its own torque and terms that act on all of it included.

    Args:
        problem: What is asked.
        terms: Beside the base model.
        used: Rows to fit.
        before: A fit to start from.
        variance: (n,) of the rows, if it is given; otherwise what is left decides.
    """
    context = problem.context if before is None else before.context
    fitted = before
    for _ in range(ROUNDS):
        last = fitted
        fitted = _once(problem, terms, used, context, before=last, variance=variance)
        context = fitted.context
        terms, moved = _stepped(fitted)
        follow = any(e is not None and holds_reference(e) for e in fitted.effects)
        if not moved and (not follow or _is_settled(fitted, last)):
            break
    if fitted is None:
        raise ValueError("a fit needs at least one round")
    return fitted


def _is_settled(fitted: Fitted, last: Fitted | None) -> bool:
    """Whether a round of the same terms changed nothing that rows tell."""
    if last is None or [t.label for t in last.terms] != [t.label for t in fitted.terms]:
        return False
    used = fitted.projection.used
    if not np.array_equal(used, last.projection.used):
        return False
    moved = (fitted.projection.residual - last.projection.residual)[:, used]
    squares = np.sum(moved**2, axis=1) / fitted.variance
    return float(squares.sum()) < NO_CHANGE


def _stepped(fitted: Fitted) -> tuple[tuple[Term, ...], bool]:
    """Terms that act on the whole model, moved on by what their columns still explain."""
    result, moved = [], False
    for term, place in zip(fitted.terms, fitted.places, strict=True):
        own = fitted.projection.coefficients[place]
        # Steps may differ in length: what a model has of it can depend on what is installed.
        whole = sum(float(np.linalg.norm(step)) for step in term.steps)
        if term.steps and len(own) and np.linalg.norm(own) > SETTLED * whole:
            sizes = tuple(float(x) for x in own)
            result.append(dataclasses.replace(term, steps=(*term.steps, sizes)))
            moved = True
        else:
            result.append(term)
    return tuple(result), moved


def _once(
    problem: Problem,
    terms: tuple[Term, ...],
    used: Bool[ndarray, " rows"],
    context: Context,
    *,
    before: Fitted | None,
    variance: Float[ndarray, " joints"] | None,
) -> Fitted:
    seen = install(problem, terms, context)
    alike = before if before is not None and steps_of(before.terms) == steps_of(terms) else None
    visible, beside_all = _base_columns(problem, seen.model, alike)
    effects, places, blocks, start = [], [], [beside_all], beside_all.shape[2]
    for term in terms:
        is_fixed = term.candidate.unit_coefficient
        effect = None if is_fixed else term.candidate.effect(seen, term.values)
        count = 0 if effect is None else len(effect.parameters)
        if effect is not None:
            own = _kept(alike, term, effect)
            if own is None:
                own = dense(white_effect(effect, seen.model, problem.rows), problem.rows, count)
            blocks.append(own)
        effects.append(effect)
        places.append(slice(start, start + count))
        start += count
    columns = np.concatenate(blocks, axis=2) if len(blocks) > 1 else blocks[0]
    precision = np.zeros((start, start))
    if np.array_equal(visible, problem.columns):  # under another gravity there are others
        precision[: len(visible), : len(visible)] = problem.base_precision
    for term, place in zip(terms, places, strict=True):
        if term.precision is not None:
            precision[place, place] = term.precision
    v = np.ones(problem.rows.joints) if before is None else before.variance
    v = v if variance is None else variance
    projection = project(problem.rows, columns, used, v, precision)
    tolerated = _tolerated(problem, places, projection, len(visible))
    counted = np.maximum(problem.rows.counts[:, used].sum(axis=1), 1.0)
    found = np.maximum(tolerated, np.sum(projection.residual[:, used] ** 2, axis=1) / counted)
    if variance is None and np.any(np.abs(found - v) > SAME_VARIANCE * v):
        v = found
        projection = project(problem.rows, columns, used, v, precision)
        tolerated = _tolerated(problem, places, projection, len(visible))
    base = full_parameters(seen.model, visible, projection.coefficients[: len(visible)])
    beside = tuple(
        (effect, projection.coefficients[place])
        for term, effect, place in zip(terms, effects, places, strict=True)
        if effect is not None and not term.steps
    )
    known = dataclasses.replace(seen, parameters=base, beside=beside)
    return Fitted(
        problem,
        terms,
        seen.model,
        tuple(effects),
        tuple(places),
        projection,
        v,
        tolerated,
        known,
        visible,
    )


def _base_columns(
    problem: Problem, model: TorqueModel, alike: Fitted | None
) -> tuple[Int[ndarray, " base"], Float[ndarray, "joints rows beside"]]:
    """Columns of the installed model that are estimated, and these and the nuisances, white.

    Args:
        problem: What is asked.
        model: The installed one.
        alike: A fit with the same steps installed, which has them if its base model is the same;
            none if None.
    """
    if alike is not None and alike.problem.base is problem.base:
        count = len(alike.columns) + problem.nuisances.shape[2]
        return alike.columns, alike.projection.columns[:, :, :count]
    visible = visible_columns(problem, model)
    both = white_model(model, visible, problem.rows), problem.nuisances
    return visible, np.concatenate(both, axis=2)


def _kept(
    before: Fitted | None, term: Term, effect: Effect
) -> Float[ndarray, "joints rows columns"] | None:
    """Columns of an effect that an earlier fit has as they are; None if they have to be worked out.

    A derivative by which a term is moved on holds until something is moved: steps of Newton's with
    an old slope (the chord method) end where those with a new one do.

    Args:
        before: A fit with the same whole model's steps; none if None.
        term: Of the effect.
        effect: Whose columns are asked for.
    """
    if before is None or (holds_reference(effect) and not term.steps):
        return None
    for old, own, place in zip(before.terms, before.effects, before.places, strict=True):
        alike = old.candidate is term.candidate and old.values == term.values
        if alike and (term.steps or own == effect):
            return before.projection.columns[:, :, place]
    return None


def _tolerated(
    problem: Problem, places: list[slice], projection: Projection, base: int
) -> Float[ndarray, " joints"]:
    """(n,) variance that a joint's rows may have without blame: formulas are true to a few per cent."""

    def power(place: slice) -> Float[ndarray, " joints"]:
        own = projection.columns[:, :, place] @ projection.coefficients[place]
        return np.sum(own**2, axis=1) / problem.rows.counted

    result = 1 + BASE_ERROR**2 * power(slice(base))
    for place in places:
        result = result + FORMULA_ERROR**2 * power(place)
    return result
