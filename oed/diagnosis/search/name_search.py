"""Names are added, exchanged and dropped until none passes all tests."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby

from oed.diagnosis.candidates.accepted import Accepted, Refused, at_home, refusal
from oed.diagnosis.candidates.turning import GRAVITY, turned
from oed.diagnosis.search.behind_noise import quieter_beside
from oed.diagnosis.search.exchange import decided_shapes, settled
from oed.diagnosis.search.next_name import next_names
from oed.diagnosis.search.other_motion import shown_by_other_motion
from oed.diagnosis.search.several import several_at_once
from oed.diagnosis.search.two_at_once import two_at_once
from oed.diagnosis.tables.sharpening import sharpened
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial

FEW = 3  # joints of an arm whose effects are added one by one
SHARPENED = 3  # times at most that tables are made anew after a name
AT_ONCE = 3  # names that are added at once to an arm of more


@dataclass
class NameSearch:
    """A search for names on its way.

    Attributes:
        shop: The tables, made anew now and then.
        refused: What was turned down so far.
        upright: Whether no tilt may be named.
        accepted: Names so far.
        barred: Keys of names that fell, and may not come back.
        grouped: Names that were tried in several joints at once.
        paired: Joints in which two names were tried at once.
        shown: Keys of names that were found in the validation recordings.
        beside: Free-form terms beside which signs are read off.
        history: The search before each addition.
    """

    shop: Workshop
    refused: list[Refused]
    upright: bool
    accepted: list[Accepted] = field(default_factory=list)
    barred: set[tuple[str, object]] = field(default_factory=set)
    grouped: set[str] = field(default_factory=set)
    paired: set[int] = field(default_factory=set)
    shown: set[tuple[str, object]] = field(default_factory=set)
    beside: tuple[Trial, ...] = ()
    history: list[NameSearch] = field(default_factory=list)

    def add_names(self) -> None:
        """Add, exchange and drop names until none passes all tests."""
        most, seen = self.shop.most_effects, [self.names]
        while len(self.accepted) + self.shop.is_turned < most:
            room = most - len(self.accepted) - self.shop.is_turned
            self.history.append(self.as_it_is())
            fresh = self._next_ones(room)
            pick = fresh[0] if fresh else None
            if pick is None:
                group = self._next_group(room) or self._next_two(room) or self._next_unseen()
                if not group:
                    break
                self.accepted += group
                fresh = group
            elif pick.trial.name == GRAVITY:
                self.shop = turned(self.shop, [a.trial for a in self.accepted])
                if not self.shop.is_turned:
                    self.barred.add(pick.trial.key)
                    self.refused.append(refusal(pick, "no tilt explains it with possible links"))
                    continue
            else:
                self.accepted += fresh
            self._settle(fresh)
            self.turn_again()
            self._sharpen(fresh)
            if pick is not None and self.names in seen:
                # They fell beside the others, or change places for ever.
                self.barred |= {a.trial.key for a in fresh}
            seen.append(self.names)

    def give_up(self, fallen: set[tuple[str, object]], names: list[Accepted]) -> None:
        """Go on without names that fell, as if they had not been found where the others were before.

        Beside what is not there, the others settle where they do not belong, and signs with them.

        Args:
            fallen: Keys of the names.
            names: The others.
        """
        self.barred |= fallen
        self.accepted = names
        left = self.names
        for before in reversed(self.history):
            if before.names == left:
                self.shop, self.accepted = before.shop, [*before.accepted]
                self.renew_context()
                break
        self.turn_again()

    def before_tilt(self) -> NameSearch | None:
        """A search that goes on from before the tables were turned, and turns them no more.

        None if they were turned from the start.
        """
        for before in reversed(self.history):
            if not before.shop.is_turned:
                before.renew_context()
                return dataclasses.replace(before.as_it_is(), upright=True)
        return None

    def sharpen(self, whole: Sequence[Accepted]) -> bool:
        """Whether signs are other ones beside what has no name; once, and the tables with them.

        What one joint lacks bends what the model makes of another, and may pass there for a sign
        that turns slowly.
        """
        free = [a.trial for a in whole if a.stands_in and a.trial.is_free_form]
        if self.beside or not free:
            return False
        self.beside = tuple(free)
        sharper = self._sharper()
        if sharper is None:
            return False
        self.shop = sharper
        return True

    def _sharpen(self, fresh: Sequence[Accepted]) -> None:
        """Make the tables anew beside what was added, and again while they get quieter.

        A floor that is read beside a first estimate holds what that lacks of the last.
        """
        for again in range(SHARPENED):
            before, sharper = self.shop.baseline.floor, self._sharper()
            if sharper is None or (again and not sharper.baseline.floor.is_below(before)):
                return
            self.shop = sharper
            self._settle(fresh)

    def _sharper(self) -> Workshop | None:
        return sharpened(self.shop, [*(a.trial for a in self.accepted), *self.beside])

    def _next_ones(self, room: int) -> list[Accepted]:
        """The next name; of an arm of many joints those of several joints."""
        most = min(room, AT_ONCE) if self.shop.context.n > FEW else 1
        found = next_names(self.shop, self.accepted, self.refused, self._pool(), most)
        if found:
            return found
        behind = self._next_behind_noise()
        return [] if behind is None else [behind]

    def turn_again(self) -> None:
        """Tables that are turned, anew: what was missing may have pulled the tilt aside."""
        if self.shop.is_turned:
            self.shop = turned(self.shop, [a.trial for a in self.accepted])
            self._settle()

    def as_it_is(self) -> NameSearch:
        """The search as it is now; what was turned down is told to both."""
        return dataclasses.replace(
            self,
            accepted=[*self.accepted],
            barred={*self.barred},
            grouped={*self.grouped},
            paired={*self.paired},
            shown={*self.shown},
            history=[*self.history],
        )

    def renew_context(self) -> None:
        """The torque that others refer to, as it was beside the names: later ones have moved it."""
        names = [a.trial for a in self.accepted]
        self.shop.update_context(self.shop.fit(names, bend=False))

    @property
    def names(self) -> tuple[bool, set[tuple[str, object]]]:
        """Keys of the names, and whether a tilt is one of them."""
        return self.shop.is_turned, {a.trial.key for a in self.accepted}

    def _next_behind_noise(self) -> Accepted | None:
        """A name that has passed for noise, in tables without it."""
        others = [a.trial for a in self.accepted]
        for beside, trial in quieter_beside(self.shop, self._pool(), others):
            accepted = [at_home(beside, a) for a in self.accepted]
            own = [beside.renewed(trial), *beside.candidates(trial.name, trial.target)]
            for pick in next_names(beside, accepted, self.refused, own):
                self.shop, self.accepted = beside, accepted
                return pick
        return None

    def _next_group(self, most: int) -> list[Accepted]:
        """One kind of effect in several joints at once; every kind has one turn."""
        for name, kind in groupby(filter(_is_plain, self._pool()), key=lambda t: t.name):
            taken = {a.trial.key for a in self.accepted}
            free = [t for t in kind if t.key not in taken]
            if name in self.grouped or len(free) > most:
                continue
            self.grouped.add(name)
            found = several_at_once(self.shop, self.accepted, free, self.refused)
            if found:
                return found
        return []

    def _next_two(self, most: int) -> list[Accepted]:
        """Two effects of one joint at once; every joint has one turn."""
        for joint in range(self.shop.context.n):
            if joint in self.paired or most < 2:
                continue
            self.paired.add(joint)
            found = two_at_once(self.shop, self.accepted, self._pool(), joint, self.refused)
            if found:
                return found
        return []

    def _next_unseen(self) -> list[Accepted]:
        """A name that the validation recordings show; every name has one turn."""
        barred = self.barred | self.shown
        found = shown_by_other_motion(self.shop, self.accepted, barred, self.refused)
        self.shown |= {a.trial.key for a in found}
        return found

    def _settle(self, fresh: Sequence[Accepted] = ()) -> None:
        accepted = [at_home(self.shop, a) for a in self.accepted]
        accepted = settled(self.shop, accepted, self._pool(), fresh)
        # What comes next is looked for beside shapes that both motions want.
        self.accepted = decided_shapes(self.shop, accepted)

    def _pool(self) -> list[Trial]:
        return [
            t
            for t in self.shop.physical
            if t.key not in self.barred and not (self.upright and t.name == GRAVITY)
        ]


def _is_plain(trial: Trial) -> bool:
    """Whether a trial is columns of one joint, without shapes and with sizes that are free."""
    return isinstance(trial.target, int) and not trial.shapes and not trial.fixed
