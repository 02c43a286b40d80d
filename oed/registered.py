"""Functions by the name that a user asks for them by, to which code from outside adds its own."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import entry_points
from typing import Any, Generic, TypeVar, cast

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])
GivenT = TypeVar("GivenT", bound=Callable[..., Any])


@dataclass(frozen=True)
class Registered(Generic[FunctionT]):
    """Functions of one kind.

    Attributes:
        kind: What one of them is, for messages, such as "optimiser".
        group: Entry points of installed packages whose modules add functions.
        own: By name, "module:function" of those that come with `oed`: imported when asked for.
        added: By name, those that were added; a later one replaces an earlier one.
        purpose: What one is asked for, for messages, such as " to export to"; nothing if empty.
    """

    kind: str
    group: str
    own: Mapping[str, str] = field(default_factory=dict)
    added: dict[str, FunctionT] = field(default_factory=dict)
    purpose: str = ""

    def add(self, name: str) -> Callable[[GivenT], GivenT]:
        """Register a function under a name.

        Raises:
            ValueError: If the name is empty.
        """
        if not name.strip():
            raise ValueError(f"{self.kind}: a name is needed")

        def register(function: GivenT) -> GivenT:
            self.added[name] = cast(FunctionT, function)
            return function

        return register

    def names(self) -> tuple[str, ...]:
        """Names that can be asked for."""
        load_entry_points(self.group)
        return tuple(dict.fromkeys((*self.own, *self.added)))

    def find(self, name: str) -> FunctionT:
        """The function of a name.

        Raises:
            ValueError: If there is none.
        """
        known = self.names()
        if name not in known:
            raise ValueError(f"no {self.kind} {name!r}{self.purpose}; known are {', '.join(known)}")
        if name in self.added:
            return self.added[name]
        module, _, function = self.own[name].partition(":")
        return getattr(importlib.import_module(module), function)


@cache
def load_entry_points(group: str) -> None:
    """Let the installed packages that have entry points of a group add what they have, once."""
    for point in entry_points(group=group):
        point.load()
