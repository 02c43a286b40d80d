"""The latest results of something costly, by the identity of what they were made of."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Result = TypeVar("Result")


class Recent(Generic[Result]):
    """Keeps the results that were asked for last; objects that make them never change."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._kept: OrderedDict[tuple[Hashable, ...], tuple[tuple[object, ...], Result]] = (
            OrderedDict()
        )

    def __reduce__(self) -> tuple[type[Recent[Result]], tuple[int]]:
        """Nothing of it goes to another process, where identities are others."""
        return Recent, (self.most,)

    def get(
        self,
        made_of: tuple[object, ...],
        make: Callable[[], Result],
        by: tuple[Hashable, ...] = (),
    ) -> Result:
        """What was made of the very same objects, or is made of them now.

        Args:
            made_of: The objects.
            make: Makes it.
            by: By what else one differs from another of the same objects; equal is the same here.
        """
        key = (*(id(item) for item in made_of), *by)
        if key not in self._kept:
            # The objects are kept too, so that no other gets the identity of one of them.
            self._kept[key] = (made_of, make())
            if len(self._kept) > self.most:
                self._kept.popitem(last=False)
        self._kept.move_to_end(key)
        return self._kept[key][1]
