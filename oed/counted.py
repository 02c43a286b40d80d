"""A number of things in words: 1 joint, 2 joints."""

from __future__ import annotations


def counted(number: int, thing: str, things: str = "") -> str:
    """The number with its noun.

    Args:
        number: How many there are.
        thing: One of them.
        things: Several of them; with an s at its end if not given.
    """
    return f"{number} {thing if number == 1 else things or f'{thing}s'}"
