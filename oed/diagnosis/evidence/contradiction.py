"""Names that recordings contradict which had no part in choosing them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.data.prepared import Prepared
from oed.diagnosis.evidence.final_model import FinalModel, errors_of
from oed.diagnosis.evidence.taken_up import with_moments_of
from oed.diagnosis.search.predict import rms
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.workshop import Workshop


def contradicted(
    shop: Workshop,
    selection: Selection,
    before: FinalModel,
    after: FinalModel,
    test: Sequence[Prepared],
) -> bool:
    """Whether all that was added together does not lower the test error.

    A search through many candidates now and then takes noise for one of them, and a small gain
    on the validation recordings for its proof.

    Args:
        shop: The laid-out data.
        selection: What was added.
        before: The base model.
        after: With the additions.
        test: Recordings that nothing was chosen by; they contradict nothing if there are none.
    """
    if not test:
        return False
    known, _ = with_moments_of(shop, selection.found, after, test)
    weights = shop.baseline.noise_share(test)
    old, new = (rms(errors_of(model, test), weights) for model in (before, known))
    return bool(np.mean((new / old) ** 2) >= 1)
