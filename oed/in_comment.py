"""Names from a user's files within comments of code that is written for a machine."""

from __future__ import annotations


def in_comment(text: str) -> str:
    """A text that ends neither a comment of C, a line, nor a docstring of Python.

    Args:
        text: As a robot's file has it.
    """
    return "".join(x if x.isprintable() and x not in '*"\\' else " " for x in text)
