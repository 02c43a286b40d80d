"""Laws of low speed that are told by nothing but a sign that turns too slowly beside them.

A Stribeck effect and a sign that turns over some speed bend friction at the same place, each the
other's way. Fitted together they may both grow and cancel, and the law then gains much over a base
model whose sign only its presence has made so slow. So it is held against the base model with the
sign that it has without the law.
"""

from __future__ import annotations

import numpy as np

from oed.diagnosis.tables.joint_sign import is_law_of_speed
from oed.diagnosis.tables.sharpening import lead_of, with_own_sign
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial


def told_by_a_sign(shop: Workshop, whole: Augmented) -> Trial | None:
    """A named law of speed that tells no more than a sign would that turns as it does without it.

    Args:
        shop: The laid-out data.
        whole: All additions, fitted.
    """
    for trial in whole.chosen:
        if not is_law_of_speed(trial):
            continue
        others = [t for t in whole.chosen if t is not trial]
        alone = with_own_sign(shop, trial.joint, others)
        if alone is None:
            continue
        lead = lead_of((shop.on(shop.baseline), whole.chosen), (alone, others))
        price = shop.settings.decisive + trial.freedom * np.log(
            shop.layout_for(whole.chosen).rows.count
        )
        if float(np.sum(lead)) < price:
            return trial
    return None
