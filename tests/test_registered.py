"""Functions by name: those that come with the library, and those that code from outside adds."""

import math

import pytest

from oed import registered
from oed.registered import Registered


def functions() -> Registered:
    return Registered("function", "oed.nothing", {"root": "math:sqrt", "power": "math:pow"})


def test_own_functions_are_imported_when_they_are_asked_for() -> None:
    assert functions().find("root") is math.sqrt


def test_added_ones_are_known_after_them_and_replace_them() -> None:
    known = functions()

    @known.add("double")
    def double(x: float) -> float:
        return 2 * x

    assert known.names() == ("root", "power", "double")
    assert known.find("double") is double
    known.add("root")(double)
    assert known.find("root") is double
    assert functions().find("root") is math.sqrt


def test_what_is_not_known_is_refused_with_what_is() -> None:
    with pytest.raises(ValueError, match="no function 'sine'; known are root, power"):
        functions().find("sine")
    with pytest.raises(ValueError, match="a name is needed"):
        functions().add(" ")


def test_installed_packages_add_theirs(monkeypatch: pytest.MonkeyPatch) -> None:
    known = functions()

    class Point:
        def load(self) -> None:
            known.add("cube")(lambda x: x**3)

    registered.load_entry_points.cache_clear()
    monkeypatch.setattr(
        registered, "entry_points", lambda group: [Point()] * (group == known.group)
    )
    assert known.find("cube")(2) == 8
    registered.load_entry_points.cache_clear()
