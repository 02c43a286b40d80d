"""Columns of a model on the rows of a problem."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.evidence.columns import dense, white_effect, white_model
from oed.diagnosis.evidence.term import Term, install, steps_of
from oed.diagnosis.problem import Problem, visible_columns
from oed.dynamics.effects.catalogue import Context
from oed.dynamics.effects.effect import Effect
from oed.dynamics.effects.on_reference import holds_reference
from oed.dynamics.torque_model import TorqueModel


@dataclass(frozen=True, eq=False)
class Design:
    """Columns of a model on all rows of a problem.

    Attributes:
        problem: What is asked.
        terms: Beside the base model.
        seen: The context with all terms installed that act on the whole model, some of them by the
            torque of its estimate.
        effects: Effect of each term, None of those that have no columns.
        places: Columns of each term.
        visible: (b,) columns of the installed model that are estimated, the first ones.
        columns: (n, R, p) white, with those of the nuisances after the base model's.
    """

    problem: Problem
    terms: tuple[Term, ...]
    seen: Context
    effects: tuple[Effect | None, ...]
    places: tuple[slice, ...]
    visible: Int[ndarray, " base"]
    columns: Float[ndarray, "joints rows columns"]

    @property
    def precision(self) -> Float[ndarray, "columns columns"]:
        """Of the prior of all coefficients."""
        count, base = self.columns.shape[2], len(self.visible)
        result = np.zeros((count, count))
        if np.array_equal(self.visible, self.problem.columns):  # under another gravity are others
            result[:base, :base] = self.problem.base_precision
        for term, place in zip(self.terms, self.places, strict=True):
            if term.precision is not None:
                result[place, place] = term.precision
        return result

    def left_ahead(self, coefficients: Float[ndarray, " columns"]) -> Float[ndarray, "joints rows"]:
        """(n, R) white torque that is left where rows are predicted: nuisances are part of no prediction.

        Args:
            coefficients: Of the columns, found on whichever rows; further ones are part of no model.
        """
        count, start, nuisances = self.columns.shape[2], len(self.visible), self.problem.nuisances
        beside = nuisances @ coefficients[start : start + nuisances.shape[2]]
        return self.problem.rows.torque - self.columns @ coefficients[:count] + beside

    def alike(self, coefficients: Float[ndarray, " columns"]) -> tuple[ndarray, ndarray]:
        """Columns that tell what is alike in all repetitions by their mean alone.

        In what repetitions differ by there is noise of the motion, which would bias the size of what
        is alike. The base model's columns have other coefficients there, which are part of no
        model and take up what noise of the torque has in common with the motion (Mundlak 1978,
        Econometrica 46(1)).

        Args:
            coefficients: Of a fit to means: what they say of terms' differences is taken off.

        Returns:
            (n, R, p + b) the columns, further ones of base columns last, and (n, R) the white torque of
            terms' differences.
        """
        base, count = len(self.visible), self.columns.shape[2]
        constant = np.zeros(count, dtype=bool)
        constant[:base] = True
        for term, place in zip(self.terms, self.places, strict=True):
            constant[place] = not term.candidate.changes
        phase = self.problem.rows.phase
        rows = np.maximum(np.bincount(phase), 1)
        joints, length, _ = self.columns.shape
        columns, told = np.empty((joints, length, count + base)), np.zeros((joints, length))
        columns[:, :, :count] = self.columns
        for j, own in enumerate(self.columns):
            for k in np.flatnonzero(constant):
                columns[j, :, k] = (np.bincount(phase, own[:, k]) / rows)[phase]
                apart = own[:, k] - columns[j, :, k]
                if k < base:
                    columns[j, :, count + k] = apart
                else:
                    told[j] += coefficients[k] * apart
        return columns, told


def lay(
    problem: Problem, terms: tuple[Term, ...], context: Context, before: Design | None = None
) -> Design:
    """White columns of a model on all rows of a problem.

    Args:
        problem: What is asked.
        terms: Beside the base model.
        context: From which effects of the model's own torque have it.
        before: Columns that may serve again.
    """
    seen = install(problem, terms, context)
    alike = before if before is not None and steps_of(before.terms) == steps_of(terms) else None
    if alike is not None and not _acts_by(alike, context):
        alike = None
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
    return Design(problem, terms, seen, tuple(effects), tuple(places), visible, columns)


def _acts_by(before: Design, context: Context) -> bool:
    """Whether the installed terms act by the torque of an estimate, if they act by the model's own at all."""
    own = any(holds_reference(effect) for effect in before.seen.model.measurement)
    return not own or np.array_equal(before.seen.parameters, context.parameters)


def _base_columns(
    problem: Problem, model: TorqueModel, alike: Design | None
) -> tuple[Int[ndarray, " base"], Float[ndarray, "joints rows beside"]]:
    """Columns of the installed model that are estimated, and these and the nuisances, white.

    Args:
        problem: What is asked.
        model: The installed one.
        alike: With the same steps installed, which has them if its base model is the same; none if
            None.
    """
    same = alike is not None and alike.problem.base is problem.base
    if alike is not None and same and alike.problem.nuisances is problem.nuisances:
        count = len(alike.visible) + problem.nuisances.shape[2]
        return alike.visible, alike.columns[:, :, :count]
    visible = visible_columns(problem, model)
    both = white_model(model, visible, problem.rows), problem.nuisances
    return visible, np.concatenate(both, axis=2)


def _kept(
    before: Design | None, term: Term, effect: Effect
) -> Float[ndarray, "joints rows columns"] | None:
    """Columns of an effect that an earlier fit has as they are; None if they have to be worked out.

    A derivative by which a term is moved on holds until something is moved: steps of Newton's with
    an old slope (the chord method) end where those with a new one do.

    Args:
        before: With the same whole model's steps; none if None.
        term: Of the effect.
        effect: Whose columns are asked for.
    """
    if before is None or (holds_reference(effect) and not term.steps):
        return None
    for old, own, place in zip(before.terms, before.effects, before.places, strict=True):
        alike = old.candidate is term.candidate and old.values == term.values
        if alike and (term.steps or own == effect):
            return before.columns[:, :, place]
    return None
