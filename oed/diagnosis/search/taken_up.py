"""Whether a recording shows a load being taken up, or recordings only differ."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from oed.diagnosis.search.scan import inflation_of, score
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial, white_group
from oed.dynamics.effects.payload import PayloadChange


def differs_alone(shop: Workshop, others: Sequence[Trial], trial: Trial) -> str | None:
    """Why nothing tells a load from recordings that differ; None if one recording shows it.

    Where it is only assumed in which order recordings were made, two of them may differ by
    anything: a load must explain more from within one of them than from between two.

    Args:
        shop: The laid-out data.
        others: Additions beside it.
        trial: What would be added.
    """
    load, context = trial.effect, shop.context
    if context.ordered or not isinstance(load, PayloadChange) or load.start is None:
        return None
    layout = shop.layout(trial)
    fit = shop.fit(others, layout).fit
    pauses = (dataclasses.replace(load, moment=moment) for moment in context.between)
    groups = (white_group(effect, layout.rows) for effect in pauses)
    gains = [score(dataclasses.replace(trial, group=group), fit).gain for group in groups]
    left = shop.fit([*others, trial], layout).fit
    noise = float(inflation_of(left)[list(trial.group)].mean())
    if score(trial, fit).gain > max(gains) + shop.settings.decisive * noise:
        return None
    return "recordings of no known order differ, and none of them shows it being taken up"
