"""A named load in recordings that no part of a diagnosis has looked at: when it is taken up there."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.pickups import read_off
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.final_model import FinalModel
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.dynamics.effects.payload import PayloadChange
from oed.experiment.preparation.prepared import Prepared


def with_moments_of(
    shop: Workshop, found: Augmented, final: FinalModel, test: Sequence[Prepared]
) -> tuple[FinalModel, dict[str, Estimated]]:
    """A final model that knows when a load is taken up in further recordings.

    No model can foretell what it is told by nobody: where a recording shows by far that the load
    comes when it would not by the clock of the others, that one number is read off it.

    Args:
        shop: The laid-out data.
        found: The additions, fitted.
        final: With all of them in their exact form.
        test: The further recordings.

    Returns:
        The model; and by name of every recording that has a moment of its own, that moment since
        its first sample, infinite if never, and the one of its being put down, if it is [s].
    """
    if not any(isinstance(t.effect, PayloadChange) for t in found.chosen):
        return final, {}
    # As it is: beside derivatives by its shapes, its parameters are those of another model.
    whole = shop.fit(found.chosen, shop.full, bend=False)
    pickups = (*shop.pickups, *read_off(shop, whole, test))
    effects = tuple(
        dataclasses.replace(effect, pickups=pickups)
        if isinstance(effect, PayloadChange)
        else effect
        for effect in final.model.effects
    )
    model = dataclasses.replace(final.model, effects=effects)
    recordings = {float(p.motion.t[0]): p for p in (*shop.estimation, *shop.validation, *test)}
    moments = {}
    for own in pickups:
        recording = recordings[own.first]
        since_start = recording.band.lead - own.first
        moments[recording.name] = Estimated("moment", own.moment + since_start, own.deviation, "s")
        if np.isfinite(own.release):
            moments[f"{recording.name}, put down"] = Estimated(
                "release", own.release + since_start, own.deviation, "s"
            )
    return dataclasses.replace(final, model=model), moments
