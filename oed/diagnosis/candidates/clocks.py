"""Whether what changes in time goes by the clock of a session, or of each recording."""

from __future__ import annotations

import dataclasses

from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.catalogue import CATALOGUE


def by_other_clock(shop: Workshop, trial: Trial) -> Trial | None:
    """An addition by the other clock, where the estimation recordings do not tell which one counts.

    A single one says nothing of whether the next goes on with its clock.

    Args:
        shop: The laid-out data.
        trial: Any addition.
    """
    if trial.is_free_form:
        return None
    shapes = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
    for place, shape in enumerate(shapes):
        if shape.scale == "choice" and shape.points == 1 and shape.lower < shape.upper:
            other = shape.lower + shape.upper - trial.values[place]
            values = (*trial.values[:place], other, *trial.values[place + 1 :])
            return shop.renewed(dataclasses.replace(trial, values=values))
    return None
