"""Laws of low speed that are told by nothing but a sign that turns too slowly beside them.

A Stribeck effect and a sign that turns over some speed bend friction at the same place, each the
other's way. Fitted together they may both grow and cancel, and the law then gains much over a base
model whose sign only its presence has made so slow. So it is held against the base model with the
sign that it has without the law.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.diagnosis.candidates.judgement import costs
from oed.diagnosis.tables.joint_sign import is_law_of_speed
from oed.diagnosis.tables.sharpening import sharpened
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
        alone = sharpened(shop, others)
        if alone is None:
            continue
        # Both in the same noise: what is asked for is the sign.
        plain = shop.on(dataclasses.replace(shop.baseline, model=alone.baseline.model))
        rest = plain.fit([plain.renewed(t) for t in others], bend=False)
        together = shop.fit(whole.chosen, bend=False)
        layout = shop.layout_for(whole.chosen)
        freedom = len(trial.effect.parameters) + trial.shapes
        price = shop.settings.decisive + freedom * np.log(layout.rows.count)
        gain = rest.fit.squares - together.fit.squares
        if gain < price:
            return trial
        old, new = plain.validation_rms(rest), shop.validation_rms(together)
        floor, counted = shop.baseline.floor.deviation, shop.unseen_full.counted
        if old is not None and new is not None and costs(old, new, floor, counted):
            return trial
    return None
