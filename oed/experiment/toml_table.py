"""A TOML table whose every access checks presence, type and range."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Never, TypeVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import DataSetError
from oed.largest_number import LARGEST

Choice = TypeVar("Choice", bound=str)


class TomlTable:
    """A TOML table whose every access checks presence and type."""

    def __init__(self, content: Mapping[str, object], path: Path, prefix: str = "") -> None:
        self._content = content
        self._path = path
        self._prefix = prefix

    def fail(self, key: str, message: str) -> Never:
        """Raise a `DataSetError` about `key`."""
        raise self.error(key, message)

    def error(self, key: str, message: str) -> DataSetError:
        """A `DataSetError` about `key`."""
        return DataSetError(message, file=str(self._path), column=f"{self._prefix}{key}")

    def only(self, *known: str) -> None:
        """Refuse keys that are not `known`."""
        for key in self._content:
            if key not in known:
                raise self.error(key, f"unknown key; {nearest(key, known)}")

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys, in the order of the file."""
        return tuple(self._content)

    def has(self, key: str) -> bool:
        """Whether the key is there."""
        return key in self._content

    def value(self, key: str) -> object:
        """The value, of whatever type; the key must be there."""
        if key not in self._content:
            raise self.error(
                key, "missing; add it (oed import writes a dataset.toml with every key)"
            )
        return self._content[key]

    def text(self, key: str) -> str:
        """Text that is not blank."""
        value = self.value(key)
        if not isinstance(value, str) or not value.strip() or "\0" in value:
            raise self.error(key, f"must be text in quotes, got {_show(value)}")
        return value

    def one_of(self, key: str, choices: Collection[Choice]) -> Choice:
        """Text that is one of `choices`."""
        value = self.text(key)
        for choice in choices:
            if choice == value:
                return choice
        raise self.error(key, f"{_show(value)} is not allowed; {nearest(value, choices)}")

    def integer(self, key: str) -> int:
        """A whole number."""
        value = self.value(key)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(key, f"must be a whole number, got {_show(value)}")
        return value

    def number(self, key: str) -> float:
        """A finite number."""
        return self._number(key, self.value(key), finite=True)

    def numbers(self, key: str, count: int) -> Float[ndarray, " count"]:
        """A list of `count` finite numbers."""
        values = self._list(key, count)
        return np.array([self._number(key, value, finite=True) for value in values])

    def number_each(self, key: str, count: int) -> Float[ndarray, " count"]:
        """`count` finite numbers from a list of them, or from one number for all."""
        if isinstance(self.value(key), list):
            return self.numbers(key, count)
        return np.full(count, self.number(key))

    def names(self, key: str) -> tuple[str, ...]:
        """A list of different names."""
        values = self.value(key)
        if not isinstance(values, list) or not values:
            raise self.error(key, f"must be a list of joint names, got {_show(values)}")
        for value in values:
            if not isinstance(value, str) or not value:
                raise self.error(key, f"must hold names in quotes, got {_show(value)}")
        twice = [name for name, times in Counter(values).items() if times > 1]
        if twice:
            raise self.error(key, f"names {twice[0]!r} twice")
        return tuple(values)

    def bounds(self, key: str, n: int) -> Float[ndarray, "n 2"]:
        """(n, 2) lower and upper bounds from [lower, upper] or one positive bound a joint."""
        return np.array([self._bound(key, value) for value in self._list(key, n)])

    def bound(self, key: str) -> tuple[float, float]:
        """Lower and upper bound from [lower, upper]."""
        return self._bound(key, self.value(key))

    def _bound(self, key: str, value: object) -> tuple[float, float]:
        if isinstance(value, list):
            if len(value) != 2:
                raise self.error(key, f"[lower, upper] needs two numbers, got {_show(value)}")
            lower, upper = (self._number(key, side, finite=False) for side in value)
            if not lower < upper:
                raise self.error(key, f"lower {lower:g} is not below upper {upper:g}")
            return lower, upper
        if key == "position":
            raise self.error(key, f"needs one [lower, upper] a joint, got {_show(value)}")
        bound = self._number(key, value, finite=False)
        if not bound > 0:
            raise self.error(key, f"must be positive, got {bound:g}")
        return -bound, bound

    def child(self, key: str) -> TomlTable:
        """The table [key]; empty if absent."""
        value = self._content.get(key, {})
        if not isinstance(value, dict):
            raise self.error(key, f"must be a table [{key}], got {_show(value)}")
        return TomlTable(value, self._path, f"{self._prefix}{key}.")

    def children(self, key: str) -> list[TomlTable]:
        """The tables [[key]], at least one."""
        values = self.value(key)
        if not isinstance(values, list) or not values:
            raise self.error(key, f"must be one [[{key}]] table a file, got {_show(values)}")
        for value in values:
            if not isinstance(value, dict):
                raise self.error(key, f"must be [[{key}]] tables, got {_show(value)}")
        return [
            TomlTable(v, self._path, f"{self._prefix}{key}[{i + 1}].") for i, v in enumerate(values)
        ]

    def _list(self, key: str, count: int) -> list[object]:
        values = self.value(key)
        if not isinstance(values, list):
            raise self.error(key, f"must be a list of {count} values, got {_show(values)}")
        if len(values) != count:
            what = "components" if key in ("gravity", "rows") else "joints"
            raise self.error(key, f"has {len(values)} values for {count} {what}")
        return values

    def _number(self, key: str, value: object, *, finite: bool) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(key, f"must be a number, got {_show(value)}")
        is_infinite = isinstance(value, float) and np.isinf(value)
        # NaN fails every comparison.
        if not (abs(value) <= LARGEST or (is_infinite and not finite)):
            raise self.error(key, f"must be a finite number below {LARGEST:g}, got {_show(value)}")
        return float(value)


def nearest(word: str, known: Collection[str]) -> str:
    """Advice for a name that is not `known`."""
    close = get_close_matches(word, known, n=1)
    choices = ", ".join(known)
    return f"did you mean {close[0]!r}? Known: {choices}" if close else f"known: {choices}"


def _show(value: object) -> str:
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > LARGEST:
        return f"a number of {value.bit_length()} bits"
    try:
        shown = repr(value)
    except ValueError:  # Python prints no integer of more than 4300 digits.
        return f"a {type(value).__name__} of huge numbers"
    return shown if len(shown) <= 60 else f"{shown[:57]}..."
