"""Names that are not claimed, because too much of their joint has none, or they foretell nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.evidence.at_its_end import is_at_its_end
from oed.diagnosis.evidence.proof import RoleProof, error_in_floors
from oed.diagnosis.evidence.verdict import FoundEffect, Unexplained, riddles
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.tables.workshop import Workshop
from oed.dynamics.effects.catalogue import CATALOGUE

# Of what is not catalogued, one name may fit a part and curves another. What a name explains must
# be so many times what the model then still lacks of its joint, where that is clear on all
# recordings; both are squares of the validation error, in noise floors.
SURELY = 5.0
CLEAR = 3.0
CLEAR_WHERE_FITTED = 2.0
# Squares of the test error that a joint's additions explain, over what they leave of it.
MOSTLY = 1.5


@dataclass(frozen=True)
class Errors:
    """Root mean squares of a joint's errors, in noise floors; zero without recordings of a role.

    Attributes:
        seen: (n,) of the augmented model on the estimation recordings.
        unseen: (n,) on the validation recordings, which may lie beyond what the others say.
        before: (n,) of the base model on the test recordings.
        after: (n,) of the augmented model on them.
        fitted: (n,) of the base model on the estimation recordings.
    """

    seen: Float[ndarray, " joints"]
    unseen: Float[ndarray, " joints"]
    before: Float[ndarray, " joints"]
    after: Float[ndarray, " joints"]
    fitted: Float[ndarray, " joints"]

    @classmethod
    def of(cls, proofs: Sequence[RoleProof], floor: Float[ndarray, " joints"]) -> Errors:
        """Those of some proofs.

        Args:
            proofs: Of the roles that there are.
            floor: (n,) noise [N m].
        """
        before = {p.role: p.before / floor for p in proofs}
        seen, unseen, after = (
            error_in_floors(proofs, floor, role) for role in ("estimation", "validation", "test")
        )
        none = np.zeros(len(floor))
        return cls(seen, unseen, before.get("test", none), after, before.get("estimation", none))


def withheld(
    shop: Workshop,
    selection: Selection,
    effects: Sequence[FoundEffect],
    unexplained: tuple[Unexplained, ...],
    errors: Errors,
) -> tuple[tuple[FoundEffect, ...], tuple[Unexplained, ...]]:
    """Names that are claimed; what has none, with the terms of those that are not.

    They stay part of the model, which they make better. A name of the whole arm holds beside none of
    its family that does not.

    Args:
        shop: The laid-out data.
        selection: What was added.
        effects: All names that hold.
        unexplained: What has no name.
        errors: Before and after.
    """
    riddling = [u for u in riddles(effects, unexplained) if u.depends_on]
    curves = {u.joint for u in riddling}
    pulled = {u.joint for u in riddling if all(c.startswith("q_") for c in u.depends_on)}
    unclaimed: set[str] = set()
    claimed, resembling = [], []
    for effect in effects:
        joint = effect.joint
        # Beside others it may be worth something, but not what its name says, or no more than chance.
        if (
            effect.validation_gain is not None and effect.validation_gain < 0
        ) or effect.p_value > shop.settings.level:
            is_claimed = False
        elif joint is None:
            is_claimed = not (effect.trial.between_repetitions and _is_most_left(errors))
            # What pulls at every joint by its position may pull as a tilt does, too.
            if effect.name == GRAVITY and pulled.issuperset(effect.trial.group):
                is_claimed = False
        else:
            is_claimed = _is_claimed(effect, joint, errors, beside_curves=joint in curves)
        if is_claimed and not is_at_its_end(shop, effect):
            claimed.append(effect)
        else:
            unclaimed |= set(CATALOGUE[effect.name].families)
            where = int(np.argmax(errors.seen)) if joint is None else joint
            resembling.append(_without_name(shop, selection, effect, where))
    # Of a gear that is none, a delay may be the rest.
    rest = [e for e in claimed if e.joint is None and unclaimed & set(CATALOGUE[e.name].families)]
    loudest = int(np.argmax(errors.unseen if errors.unseen.any() else errors.seen))
    resembling += [_without_name(shop, selection, e, loudest) for e in rest]
    kept = tuple(e for e in claimed if all(e is not r for r in rest))
    return kept, (*unexplained, *resembling)


def _is_claimed(effect: FoundEffect, joint: int, errors: Errors, *, beside_curves: bool) -> bool:
    # What the test recordings contradict is not claimed.
    if any(_is_contradicted(errors, j) for j in effect.trial.places if j is not None):
        return False
    if not beside_curves or float(errors.seen[joint]) ** 2 - 1 < CLEAR_WHERE_FITTED:
        return True
    return _is_sure(effect, float(errors.unseen[joint]))


def _is_most_left(errors: Errors) -> bool:
    """Whether the model clearly lacks more, where it was fitted, than all additions explain.

    A load parts the recordings at a moment: of what rang for a while, it takes a share.
    """
    left = np.maximum(errors.seen**2 - 1, 0.0)
    explained = np.sum(errors.fitted**2 - errors.seen**2)
    return bool(left.max() > CLEAR_WHERE_FITTED and explained < left.sum())


def _is_contradicted(errors: Errors, joint: int) -> bool:
    missed = float(errors.after[joint]) ** 2 - 1
    return missed > CLEAR and float(errors.before[joint]) ** 2 - 1 < (1 + MOSTLY) * missed


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
