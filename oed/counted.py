"""Numbers of things, and their names, in few words: 2 joints, q_1 … q_6."""

from __future__ import annotations

from collections.abc import Sequence

MOST_SHOWN = 12  # names in a message: more are not read


def counted(number: int, thing: str, things: str = "") -> str:
    """The number with its noun.

    Args:
        number: How many there are.
        thing: One of them.
        things: Several of them; with an s at its end if not given.
    """
    return f"{number} {thing if number == 1 else things or f'{thing}s'}"


def as_one(names: Sequence[str]) -> str:
    """Names that belong together by the first and the last."""
    return f"{names[0]} … {names[-1]}" if len(names) > 1 else names[0]


def listed(names: Sequence[str], most: int = MOST_SHOWN, things: str = "") -> str:
    """Names in a message, as many as can be read, and how many there are where these are not all.

    Args:
        names: In their order.
        most: That are shown.
        things: What they are, where that is to be said.
    """
    if len(names) <= most:
        return ", ".join(names)
    what = f"{len(names)} {things}".rstrip()
    return f"{', '.join(names[:most])}, … ({what} in all)"
