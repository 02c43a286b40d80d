"""What recordings that were neither fitted nor foretold in the search say of what it found."""

from __future__ import annotations

from collections.abc import Sequence

from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.final_model import FinalModel, errors_of
from oed.diagnosis.evidence.taken_up import with_moments_of
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.tables.predict import rms
from oed.diagnosis.tables.workshop import Workshop
from oed.experiment.preparation.prepared import Prepared


def checked_errors(
    shop: Workshop,
    selection: Selection,
    before: FinalModel,
    after: FinalModel,
    test: Sequence[Prepared],
) -> tuple[Float[ndarray, " joints"], Float[ndarray, " joints"]]:
    """Each joint's test error without what was added, and with all of it [noise floors].

    Args:
        shop: The laid-out data.
        selection: What was added.
        before: The base model.
        after: With the additions.
        test: At least one.
    """
    known, _ = with_moments_of(shop, selection.found, after, test)
    floor = shop.baseline.floor.deviation
    old, new = (held_out_rms(shop, model, test) / floor for model in (before, known))
    return old, new


def held_out_rms(
    shop: Workshop, model: FinalModel, recordings: Sequence[Prepared]
) -> Float[ndarray, " joints"]:
    """Each joint's error, rows weighed by their share of noise [N m]."""
    return rms(errors_of(model, recordings), shop.baseline.noise_share(recordings))
