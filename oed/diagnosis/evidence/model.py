"""The model's state, one value, and its fit."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.diagnosis.evidence.criterion import log_score
from oed.diagnosis.evidence.design import Design, lay
from oed.diagnosis.evidence.fit import Projection, project
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.numbers import BASE_ERROR, FORMULA_ERROR, ROUNDS
from oed.diagnosis.problem import Problem, full_parameters
from oed.dynamics.effects.catalogue import Context
from oed.dynamics.effects.effect import Effect
from oed.dynamics.effects.on_reference import holds_reference
from oed.dynamics.torque_model import TorqueModel

SETTLED = 1e-3  # of a size, below which a step of it is none
SAME_VARIANCE = 0.02  # of a joint's: weights so little off cost a ten-thousandth of the information
NO_CHANGE = 0.1  # sum of squares of a change, in units of what is left: a twentieth of a nat


@dataclass(frozen=True, eq=False)
class Fitted:
    """Terms beside the base model, fitted to rows.

    Attributes:
        design: The model's columns.
        projection: The fit.
        variance: (n,) v, the larger of what is left and what is tolerated, in units of noise.
        tolerated: (n,) phi.
        context: The problem's with what was fitted.
    """

    design: Design
    projection: Projection
    variance: Float[ndarray, " joints"]
    tolerated: Float[ndarray, " joints"]
    context: Context

    @property
    def problem(self) -> Problem:
        """What is asked."""
        return self.design.problem

    @property
    def terms(self) -> tuple[Term, ...]:
        """Beside the base model."""
        return self.design.terms

    @property
    def installed(self) -> TorqueModel:
        """The base model with all terms that act on the whole of it."""
        return self.design.seen.model

    @property
    def torque_model(self) -> TorqueModel:
        """The installed model with all terms that have columns: an ordinary one."""
        return self.installed.with_effects(*(effect for effect, _ in self.added))

    @property
    def added(self) -> list[tuple[Effect, Float[ndarray, " columns"]]]:
        """Effect and coefficients of each term that has columns."""
        every = zip(self.terms, self.effects, self.coefficients, strict=True)
        return [(effect, size) for term, effect, size in every if effect and not term.steps]

    @property
    def effects(self) -> tuple[Effect | None, ...]:
        """Effect of each term, None of those that have no columns."""
        return self.design.effects

    @property
    def places(self) -> tuple[slice, ...]:
        """Columns of each term in the design."""
        return self.design.places

    @property
    def columns(self) -> Int[ndarray, " base"]:
        """(b,) of the installed model that are estimated."""
        return self.design.visible

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

        Rows that are predicted, `is_ahead`, are so without nuisances.
        """
        left = self.projection.residual
        if is_ahead:
            left = self.design.left_ahead(self.projection.coefficients)
        left = left[:, where]
        return np.sum(left**2, axis=1)

    def rows(self, where: Bool[ndarray, " rows"]) -> Float[ndarray, " joints"]:
        """(n,) how many of them count."""
        return np.maximum(self.problem.rows.counts[:, where].sum(axis=1), 1.0)

    def score(self, where: Bool[ndarray, " rows"], *, is_ahead: bool = False) -> float:
        """Log score of some rows, as in `squares` [nats]."""
        squares = self.squares(where, is_ahead=is_ahead)
        return log_score(squares, self.rows(where), self.tolerated)

    def size(self, number: int) -> Float[ndarray, " columns"]:
        """Of a term: what of it is installed in the whole model, and what its columns still add."""
        term, own = self.terms[number], self.coefficients[number]
        if not term.steps:
            return own
        installed = term.candidate.size_in(self.problem.base, self.installed)
        if installed is None:
            # A step to a coefficient of 1 by construction has no column that could move it on.
            installed = np.sum([step[: len(own) or None] for step in term.steps], axis=0)
        return installed[: len(own)] + own if len(own) else installed

    def excluded(self, number: int) -> str | None:
        """Why a term's prior has no support where it was fitted; None where it has."""
        term, context = self.terms[number], self.context
        if term.steps:
            context = dataclasses.replace(context, model=self.problem.base)
        return term.candidate.excluded(context, term.values, self.size(number))

    def at_torque_of(self, whole: Fitted) -> Fitted:
        """This fit, with the torque of another as that by which effects of the model's own torque act."""
        own, other = self.context, whole.context
        now = dataclasses.replace(own, parameters=other.parameters, beside=other.beside)
        return dataclasses.replace(self, context=now)

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
    *,
    settled: bool = False,
) -> Fitted:
    """Fit a model, effects of its own torque and terms that act on all of it included.

    Args:
        problem: What is asked.
        terms: Beside the base model.
        used: Rows to fit.
        before: A fit to start from.
        variance: (n,) of the rows, if it is given; otherwise what is left decides.
        settled: Whether installed sizes are moved on until they stay, or only until rows tell no more.
    """
    context = problem.context if before is None else before.context
    fitted = before
    for _ in range(ROUNDS):
        last = fitted
        design = lay(problem, terms, context, None if last is None else last.design)
        fitted = _fitted(design, used, last, variance)
        context = fitted.context
        terms, moved = _stepped(fitted, settled=settled)
        acting = (*fitted.effects, *fitted.installed.measurement)
        follow = any(effect is not None and holds_reference(effect) for effect in acting)
        if not moved and (not follow or _is_settled(fitted, last)):
            break
    if fitted is None:
        raise ValueError("a fit needs at least one round")
    return fitted


def fit_all(
    design: Design,
    means: Fitted,
    used: Bool[ndarray, " rows"],
    variance: Float[ndarray, " joints"] | None = None,
) -> Fitted:
    """Fit a model to all repetitions that was fitted to their means.

    What changes between repetitions is told by all rows, all else by their mean (`Design.alike`).

    Args:
        design: Its columns on all rows.
        means: The fit to means.
        used: As of `fit`.
        variance: As of `fit`.
    """
    columns, apart = design.alike(means.projection.coefficients)
    return _fitted(design, used, means, variance, columns=columns, apart=apart)


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


def _stepped(fitted: Fitted, *, settled: bool) -> tuple[tuple[Term, ...], bool]:
    """Terms that act on the whole model, moved on by what their columns still explain."""
    result, moved = [], False
    for term, place in zip(fitted.terms, fitted.places, strict=True):
        own = fitted.projection.coefficients[place]
        if term.steps and len(own) and _moves(fitted, term, place, settled=settled):
            sizes = tuple(float(x) for x in own)
            result.append(dataclasses.replace(term, steps=(*term.steps, sizes)))
            moved = True
        else:
            result.append(term)
    return tuple(result), moved


def _moves(fitted: Fitted, term: Term, place: slice, *, settled: bool) -> bool:
    """Whether a step of a term that acts on the whole model is worth working its columns out anew.

    The fit has the step d to first order, C d. What is installed, s, is in the main of first order
    too, |f''| s^2 / 2 < |C s|: so what the step leaves out, |f''| d^2 / 2, is below |C d| d / s.
    """
    own = fitted.projection.coefficients[place]
    # Steps may differ in length: what a model has of it can depend on what is installed.
    whole = sum(float(np.linalg.norm(step)) for step in term.steps)
    step = float(np.linalg.norm(own))
    if settled or step >= whole:
        return step > SETTLED * whole
    used = fitted.projection.used
    given = fitted.projection.columns[:, :, place] @ own
    squares = np.sum(given[:, used] ** 2, axis=1) / fitted.variance
    return float(squares.sum()) * (step / whole) ** 2 >= NO_CHANGE


def _fitted(
    design: Design,
    used: Bool[ndarray, " rows"],
    before: Fitted | None,
    variance: Float[ndarray, " joints"] | None,
    *,
    columns: Float[ndarray, "joints rows columns"] | None = None,
    apart: Float[ndarray, "joints rows"] | float = 0.0,
) -> Fitted:
    rows = design.problem.rows
    columns = design.columns if columns is None else columns
    torque = rows.torque - apart
    precision = np.pad(design.precision, (0, columns.shape[2] - design.columns.shape[2]))
    start = np.ones(rows.joints) if before is None else before.variance
    v = start if variance is None else variance
    known = None if before is None else before.projection
    projection = project(torque, columns, used, v, precision, before=known)
    tolerated = _tolerated(design, projection)
    counted = np.maximum(rows.counts[:, used].sum(axis=1), 1.0)
    # A joint with large errors bends what another is fitted with, until its weight is small.
    for _ in range(ROUNDS if variance is None else 0):
        found = np.maximum(tolerated, np.sum(projection.residual[:, used] ** 2, axis=1) / counted)
        if np.all(np.abs(found - v) <= SAME_VARIANCE * v):
            break
        v = found
        projection = project(torque, columns, used, v, precision, before=projection)
        tolerated = _tolerated(design, projection)
    beside = tuple(
        (effect, projection.coefficients[place])
        for term, effect, place in zip(design.terms, design.effects, design.places, strict=True)
        if effect is not None and not term.steps
    )
    told = projection.coefficients[: len(design.visible)]
    base = full_parameters(design.seen.model, design.visible, told)
    seen = dataclasses.replace(design.seen, parameters=base, beside=beside)
    return Fitted(design, projection, v, tolerated, seen)


def _tolerated(design: Design, projection: Projection) -> Float[ndarray, " joints"]:
    """(n,) variance that a joint's rows may have without blame: formulas are true to a few per cent.

    Of a term only what nothing else could give: terms that explain the same are held to the same.
    """
    counted, base = design.problem.rows.counted, slice(len(design.visible))
    given = projection.columns[:, :, base] @ projection.coefficients[base]
    noise = float(design.problem.is_floor_measured)
    result = noise + BASE_ERROR**2 * np.sum(given**2, axis=1) / counted
    for place in design.places:
        own = projection.beyond_others(place)
        result = result + FORMULA_ERROR**2 * np.sum(own**2, axis=1) / counted
    return result
