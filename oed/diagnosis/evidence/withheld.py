"""Names that are not claimed, because too much of their joint has none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.verdict import FoundEffect, Unexplained, riddles
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.workshop import Workshop

# Of what is not catalogued, one name may fit a part and curves another. What a name explains must
# be so many times what the model then still lacks of its joint, where that is clear on all
# recordings; both are squares of the validation error, in noise floors.
SURELY = 5.0
CLEAR = 3.0


def withheld(
    shop: Workshop,
    selection: Selection,
    effects: Sequence[FoundEffect],
    unexplained: tuple[Unexplained, ...],
    errors: tuple[Float[ndarray, " joints"], Float[ndarray, " joints"]],
) -> tuple[tuple[FoundEffect, ...], tuple[Unexplained, ...]]:
    """Names that are claimed; what has none, with the terms of those that are not.

    They stay part of the model, which they make better.

    Args:
        shop: The laid-out data.
        selection: What was added.
        effects: All names that hold.
        unexplained: What has no name.
        errors: (n,) errors of the augmented model, in noise floors: on the estimation recordings,
            and on the validation recordings, which may lie beyond what the others say of an effect.
    """
    seen, unseen = errors
    curves = {u.joint for u in riddles(effects, unexplained) if u.depends_on}
    claimed, resembling = [], []
    for effect in effects:
        joint = effect.joint
        if (
            joint is None
            or joint not in curves
            or seen[joint] ** 2 - 1 < CLEAR
            or _is_sure(effect, float(unseen[joint]))
        ):
            claimed.append(effect)
        else:
            resembling.append(_without_name(shop, selection, effect, joint))
    return tuple(claimed), (*unexplained, *resembling)


def _is_sure(effect: FoundEffect, unseen: float) -> bool:
    lacks = unseen**2 - 1
    if lacks < CLEAR or effect.validation_gain is None:
        return True
    lowered = 1 - min(effect.validation_gain, 1 - 1e-6)
    return unseen**2 * (1 / lowered**2 - 1) > SURELY * lacks


def _without_name(
    shop: Workshop, selection: Selection, effect: FoundEffect, joint: int
) -> Unexplained:
    item = next(a for a in selection.accepted if a.trial.key == effect.trial.key)
    residual = shop.fit((), shop.layout(item.trial)).fit.residual[list(item.trial.group)]
    return Unexplained(
        joint,
        effect.trial.effect.depends_on,
        min(1.0, item.gain / float(np.sum(residual**2))),
        f"what {effect.name} fits best, of more that has no name",
        stands_in=True,
        trial=effect.trial,
    )
