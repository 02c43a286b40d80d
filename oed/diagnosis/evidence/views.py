"""One model on two channels: the mean over repetitions, and how these differ.

What is alike in all repetitions shows in their mean; what a term explains of their differences as
well is noise, such as that of a motion which noise of the torque has shaken.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.diagnosis.candidates.candidate import Candidate
from oed.diagnosis.evidence.criterion import Moments, log_score
from oed.diagnosis.evidence.design import Design, lay
from oed.diagnosis.evidence.model import Fitted, fit, fit_all
from oed.diagnosis.evidence.moments import columns_of, moments_of
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.problem import Problem

Which = Literal["fitted", "held_out", "all"]
# Times the columns of a fit: making one takes 1.7 times them (measured on the TX40 and the Panda), and where
# a term is put in the place of another three are held.
TAKEN = 5


def chosen(problem: Problem, which: Which) -> Bool[ndarray, " rows"]:
    """Rows of a kind."""
    rows = problem.rows
    return {"fitted": rows.fitted, "held_out": rows.held_out, "all": rows.fitted | rows.held_out}[
        which
    ]


@dataclass(frozen=True, eq=False)
class Views:
    """One model fitted to the means of repetitions, and to all rows where that is asked for.

    Attributes:
        problem: What is asked; its base model's signs turn as they fit best beside the terms.
        means: On means; on all rows where no motion was repeated.
        which: Rows that are fitted.
        like: A model whose variance the rows are given; what is left decides if None.
        known: Columns on all rows that may serve again; none if None.
        first: The model from which a search started; None for that itself.
    """

    problem: Problem
    means: Fitted
    which: Which
    like: Views | None = None
    known: Design | None = None
    first: Views | None = None

    @classmethod
    def of(
        cls,
        problem: Problem,
        terms: tuple[Term, ...],
        which: Which,
        before: Views | None = None,
        like: Views | None = None,
        *,
        settled: bool = False,
    ) -> Views:
        """Fit a model.

        Args:
            problem: What is asked.
            terms: Of the model.
            which: Rows that are fitted.
            before: Fits to start from.
            like: A model whose variance the rows are given; what is left decides if None.
            settled: As of `fit`: for a model that is handed on.
        """
        sparse = problem.sparse
        start, variance = before and before.means, like and like.means.variance
        means = fit(sparse, terms, chosen(sparse, which), start, variance, settled=settled)
        first = before and (before.first or before)
        return cls(problem, means, which, like, before and before.laid, first)

    @cached_property
    def every(self) -> Fitted:
        """On all rows."""
        if self.problem.means is None:
            return self.means
        variance = self.like and self.like.every.variance
        used = chosen(self.problem, self.which)
        return fit_all(self._design, self.means, used, variance)

    def shared(self) -> Views:
        """Itself, with what is compared of it again and again worked out: processes that fork share it."""
        _ = self.told, self._design
        return self

    @property
    def nbytes(self) -> int:
        """About how much another fit of this size takes, while it is made [bytes]."""
        design = self.laid or self.means.design
        return TAKEN * design.columns.nbytes

    @property
    def told(self) -> Fitted:
        """The fit whose numbers are handed on: of the channel that shows all its terms."""
        return self.every if self.changes else self.means

    @cached_property
    def _design(self) -> Design:
        """Columns on all rows, of the terms as they are in the fit to means."""
        if self.problem.means is None:
            return self.means.design
        return lay(self.problem, self.means.terms, self.means.context, self.known)

    @property
    def laid(self) -> Design | None:
        """Columns on all rows that were worked out last, of this model or one before."""
        return self.__dict__.get("_design", self.known)

    def grown(self, terms: tuple[Term, ...], which: Which, like: Views | None = None) -> Views:
        """Other terms beside the same base model."""
        return Views.of(self.problem, terms, which, self, like)

    @property
    def terms(self) -> tuple[Term, ...]:
        """Of the model."""
        return self.told.terms

    def others(self, number: int) -> tuple[Term, ...]:
        """All terms but one."""
        return tuple(t for k, t in enumerate(self.terms) if k != number)

    @property
    def labels(self) -> frozenset[str]:
        """Of its terms."""
        return frozenset(term.label for term in self.terms)

    def showing(self, candidate: Candidate) -> Fitted:
        """The fit that shows a candidate in fewest rows."""
        return self.every if candidate.changes else self.means

    def left(self, which: Which) -> Float[ndarray, " joints"]:
        """(n,) mean square of what is left of the mean, and of what is explained of differences.

        What the first model leaves of these is noise: what a term explains of it is no gain, and no
        more is what it adds. Of rows that are held out it is what a prediction leaves, nuisances no
        part of it.
        """
        means = chosen(self.means.problem, which)
        own = self.means.squares(means, is_ahead=which == "held_out") / self.means.rows(means)
        if self.problem.means is None:
            return own
        first = self.first or self
        return own + np.maximum(first.apart(which) - self.apart(which), 0.0)

    def apart(self, which: Which) -> Float[ndarray, " joints"]:
        """(n,) mean square of what the told fit leaves of differences between repetitions.

        Nuisances are part of no prediction, and of no difference either.
        """
        told = self.told.projection.coefficients
        left = self._design.left_ahead(told)
        every, means = (chosen(p, which) for p in (self.problem, self.problem.sparse))
        apart = np.sum(left[:, every] ** 2, axis=1) - self.means.squares(means, is_ahead=True)
        counted = self.problem.rows.counts[:, every].sum(axis=1) - self.means.rows(means)
        return apart / np.maximum(counted, 1.0)

    @property
    def changes(self) -> bool:
        """Whether a term of it makes repetitions differ, which their mean does not show."""
        return any(term.candidate.changes for term in self.means.terms)

    def rise(self, before: Views, which: Which) -> float:
        """Rise of the log score from another model to this one, on the same rows [nats].

        Repetitions count one by one, not by their mean, where either has a term that changes
        between them.
        """
        changing = self.changes or before.changes
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
