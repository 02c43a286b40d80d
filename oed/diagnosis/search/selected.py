"""What a search added, and what it turned down."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from oed.diagnosis.candidates.accepted import Accepted, Refused, refusal
from oed.diagnosis.tables.sharpening import sharpened
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial


@dataclass(frozen=True)
class Selection:
    """Outcome of the search.

    Attributes:
        accepted: Additions in the order of their acceptance.
        found: The fit with all of them.
        refused: What was turned down on the way.
    """

    accepted: tuple[Accepted, ...]
    found: Augmented
    refused: tuple[Refused, ...]

    @classmethod
    def of(
        cls, shop: Workshop, accepted: Sequence[Accepted], refused: Sequence[Refused]
    ) -> Selection:
        """Additions with the fit of those that are part of the model."""
        found = shop.fit([a.trial for a in accepted if a.stands_in])
        return cls(tuple(accepted), found, tuple(refused))

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The additions that are part of the model."""
        return tuple(a.trial for a in self.accepted if a.stands_in)

    def sharpened(self, shop: Workshop) -> tuple[Workshop, Selection]:
        """Tables with the signs that stand beside these additions, and the same on them."""
        sharper = sharpened(shop, self.trials)
        if sharper is None:
            return shop, self
        sharper.settle(self.trials)
        moved = [dataclasses.replace(a, trial=sharper.renewed(a.trial)) for a in self.accepted]
        return sharper, Selection.of(sharper, moved, self.refused)

    def without(self, shop: Workshop, trial: Trial, reason: str) -> Selection:
        """The same with one addition turned down after all."""
        return self._without(shop, {trial.key}, reason)

    def with_only(
        self, shop: Workshop, keys: Collection[tuple[str, object]], reason: str
    ) -> Selection:
        """The same with no addition that is part of the model but these."""
        return self._without(shop, {t.key for t in self.trials} - set(keys), reason)

    def _without(
        self, shop: Workshop, keys: Collection[tuple[str, object]], reason: str
    ) -> Selection:
        kept = [a for a in self.accepted if a.trial.key not in keys]
        gone = [refusal(a, reason) for a in self.accepted if a.trial.key in keys]
        return Selection.of(shop, kept, [*self.refused, *gone])

    def with_aside(self, shop: Workshop, terms: Collection[Trial]) -> Selection:
        """The same with some free-form terms only to say where something is missing."""
        aside = {t.key for t in terms}
        accepted = [
            dataclasses.replace(a, stands_in=False) if a.trial.key in aside else a
            for a in self.accepted
        ]
        return Selection.of(shop, accepted, self.refused)

    def exchanged(self, shop: Workshop, trial: Trial, rival: Trial) -> Selection:
        """The same with another addition in the place of one."""
        kept = [
            dataclasses.replace(a, trial=rival) if a.trial.key == trial.key else a
            for a in self.accepted
        ]
        return Selection.of(shop, kept, self.refused)
