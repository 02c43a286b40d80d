"""Names that the other motion shows.

What the estimation recordings hardly excite may be all that the validation recordings lack: friction
near standstill of an arm that never went slowly. So where the fit foretells badly and nothing more is
found, roles change: a name is looked for in the validation recordings, and must pay on the others.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted, Refused, at_home
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.search.next_name import next_names
from oed.diagnosis.tables.workshop import Workshop

BADLY = 2.0  # root mean square of what is foretold, in noises


def shown_by_other_motion(
    shop: Workshop,
    accepted: Sequence[Accepted],
    barred: set[tuple[str, object]],
    refused: list[Refused],
) -> list[Accepted]:
    """The name that the validation recordings ask for most; none if they are foretold well.

    Args:
        shop: The laid-out data.
        accepted: Additions so far.
        barred: Keys of names that may not come.
        refused: Takes in what is turned down.
    """
    chosen = [a.trial for a in accepted]
    unseen = shop.unseen_by(chosen)
    left = unseen.left(shop.fit(chosen, bend=False)) / unseen.counted
    joints = set(np.flatnonzero(left > BADLY**2).tolist())
    if not joints or shop.pickups:
        return []
    other = _with_roles_changed(shop)
    taken = barred | {t.key for t in chosen}
    pool = [
        t for t in other.physical if t.joint in joints and t.name != GRAVITY and t.key not in taken
    ]
    there = [at_home(other, a) for a in accepted]
    return [at_home(shop, pick) for pick in next_names(other, there, refused, pool)]


def _with_roles_changed(shop: Workshop) -> Workshop:
    """Tables of the validation recordings, with the others held out."""
    return Workshop(
        shop.baseline,
        shop.validation,
        shop.estimation,
        shop.settings,
        drives=shop.drives,
        declared=shop.declared,
    )
