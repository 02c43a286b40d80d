"""One model on two channels: the mean over repetitions, and how these differ.

What is alike in all repetitions shows in their mean; what a term explains of their differences as
well is noise, such as that of a motion which noise of the torque has shaken.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.diagnosis.candidates.candidate import Candidate
from oed.diagnosis.evidence.criterion import Moments, log_score
from oed.diagnosis.evidence.model import Fitted, fit
from oed.diagnosis.evidence.moments import columns_of, moments_of
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.numbers import LEAST_LEFT
from oed.diagnosis.problem import Problem

Which = Literal["fitted", "held_out", "all"]


def chosen(problem: Problem, which: Which) -> Bool[ndarray, " rows"]:
    """Rows of a kind."""
    rows = problem.rows
    return {"fitted": rows.fitted, "held_out": rows.held_out, "all": rows.fitted | rows.held_out}[
        which
    ]


@dataclass(frozen=True, eq=False)
class Views:
    """One model fitted to all rows, and to the means of repetitions.

    Attributes:
        every: On all rows.
        means: On means; the same object where no motion was repeated.
    """

    every: Fitted
    means: Fitted

    @classmethod
    def of(
        cls,
        problem: Problem,
        terms: tuple[Term, ...],
        which: Which,
        before: Views | None = None,
        like: Views | None = None,
    ) -> Views:
        """Fit a model on both.

        Args:
            problem: What is asked.
            terms: Of the model.
            which: Rows that are fitted.
            before: Fits to start from.
            like: A model whose variance the rows are given; what is left decides if None.
        """

        def fitted(own: Problem, side: Callable[[Views], Fitted]) -> Fitted:
            start, variance = before and side(before), like and side(like).variance
            return fit(own, terms, chosen(own, which), start, variance)

        every = fitted(problem, lambda views: views.every)
        if problem.means is None:
            return cls(every, every)
        return cls(every, fitted(problem.means, lambda views: views.means))

    @property
    def problem(self) -> Problem:
        """What is asked; its base model's signs turn as they fit best beside these terms."""
        return self.every.problem

    def grown(self, terms: tuple[Term, ...], which: Which, like: Views | None = None) -> Views:
        """Other terms beside the same base model."""
        return Views.of(self.problem, terms, which, self, like)

    @property
    def terms(self) -> tuple[Term, ...]:
        """Of the model."""
        return self.every.terms

    @property
    def labels(self) -> frozenset[str]:
        """Of its terms."""
        return frozenset(term.label for term in self.terms)

    def showing(self, candidate: Candidate) -> Fitted:
        """The fit that shows a candidate in fewest rows."""
        return self.every if candidate.changes else self.means

    def left(self, which: Which) -> Float[ndarray, " joints"]:
        """(n,) mean square of what is left of the mean, less what is left of differences, plus 1.

        Of rows that are held out it is what a prediction leaves, nuisances no part of it.
        """
        means, is_ahead = chosen(self.means.problem, which), which == "held_out"
        squares = self.means.squares(means, is_ahead=is_ahead)
        own = squares / self.means.rows(means)
        if self.means is self.every:
            return own
        every = chosen(self.every.problem, which)
        apart = self.every.squares(every, is_ahead=is_ahead) - squares
        count = np.maximum(self.every.rows(every) - self.means.rows(means), 1.0)
        return np.maximum(own + (1 - apart / count), LEAST_LEFT)

    @property
    def changes(self) -> bool:
        """Whether a term of it makes repetitions differ, which their mean does not show."""
        return any(term.candidate.changes for term in self.terms)

    def rise(self, before: Views, which: Which, *, on_all: bool | None = None) -> float:
        """Rise of the log score from another model to this one, on the same rows [nats].

        Args:
            before: The other.
            which: Rows.
            on_all: Whether repetitions count one by one, not by their mean; where either model has a
                term that only this shows if None.
        """
        changing = self.changes or before.changes if on_all is None else on_all
        return self._score(which, changing) - before._score(which, changing)

    def _score(self, which: Which, changing: bool) -> float:
        if changing:
            every = chosen(self.every.problem, which)
            return self.every.score(every, is_ahead=which == "held_out")
        rows = self.means.rows(chosen(self.means.problem, which))
        return log_score(self.left(which) * rows, rows, self.means.tolerated)


def moments(
    whole: Views,
    number: int,
    rest: Views,
    tau: float | None = None,
    *,
    changes: bool | None = None,
) -> Moments:
    """What rows tell of a term of a model: what it explains of the mean, less what of differences.

    Args:
        whole: With the term.
        number: Of the term.
        rest: Without it, its variance that of the whole.
        tau: Dilution if it is known.
        changes: Whether all rows tell, as of what changes between repetitions; as the term has it
            if None.
    """
    term = whole.terms[number]
    changes = term.candidate.changes if changes is None else changes
    fitted, without = (v.every if changes else v.means for v in (whole, rest))
    used = fitted.projection.used
    tolerated = np.maximum(fitted.tolerated, without.tolerated)
    rows = fitted.rows(used)
    if changes:
        own, others = (f.squares(used) for f in (fitted, without))
    else:
        own, others = (v.left("all") * rows for v in (whole, rest))
    gained = log_score(own, rows, tolerated) - log_score(others, rows, tolerated)
    columns = columns_of(term, fitted, fitted.places[number])
    return moments_of(fitted, without.projection, columns, used, gained=gained, tau=tau)
