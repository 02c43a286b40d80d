"""A candidate as part of a model, and those that are installed in the whole of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.candidate import Candidate, NamedCandidate, Values
from oed.diagnosis.problem import Problem
from oed.dynamics.effects.catalogue import Context

Sizes = tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Term:
    """A candidate that is part of a model.

    Attributes:
        candidate: What it is.
        values: Of its shapes.
        steps: Sizes that were installed in the whole model, one after another, of a candidate
            that acts on it; others have none.
        precision: Of a smooth term's prior.
    """

    candidate: Candidate
    values: Values
    steps: tuple[Sizes, ...] = ()
    precision: Float[ndarray, "columns columns"] | None = field(default=None, repr=False)

    @property
    def label(self) -> str:
        """Of the candidate."""
        return self.candidate.label


def install(problem: Problem, terms: tuple[Term, ...], context: Context) -> Context:
    """The context whose model has all terms that act on the whole of it."""
    context = dataclasses.replace(context, model=problem.base)
    for term in terms:
        if isinstance(term.candidate, NamedCandidate):
            for sizes in term.steps:
                model = term.candidate.install(context, term.values, np.array(sizes))
                context = dataclasses.replace(context, model=model)
    return context


def steps_of(terms: tuple[Term, ...]) -> list[tuple]:
    """What of terms is installed in the whole model."""
    return [(term.label, term.values, term.steps) for term in terms if term.steps]
