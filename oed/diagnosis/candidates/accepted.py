"""What a search added, and what it turned down."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score
from oed.diagnosis.terms.trials import Trial


@dataclass(frozen=True)
class Accepted:
    """An addition.

    Attributes:
        trial: The addition.
        gain: Fall of the white sum of squares, at the time it was accepted.
        stands_in: Whether it is part of the model. A free-form term that does not predict
            what it was not fitted to only says where something is missing.
    """

    trial: Trial
    gain: float
    stands_in: bool = True


@dataclass(frozen=True)
class Refused:
    """A candidate that looked good and was turned down.

    Attributes:
        name: Of the catalogue, or the free-form term's label.
        joint: Index, None for the whole arm.
        gain: Fall of the white sum of squares that it promised.
        reason: Why it was turned down.
    """

    name: str
    joint: int | None
    gain: float
    reason: str


def refusal(candidate: Score | Accepted, reason: str) -> Refused:
    """A candidate, or what was accepted once, turned down in words."""
    trial = candidate.trial
    return Refused(str(trial.key[0]), trial.joint, candidate.gain, reason)


def at_home(shop: Workshop, item: Accepted) -> Accepted:
    """An addition on the rows of new tables."""
    return dataclasses.replace(item, trial=shop.renewed(item.trial))
