"""A command, run as a user runs it, in this process."""

from __future__ import annotations

from oed.commands.main import run


def oed(*arguments: object) -> int:
    """Exit status of `oed ARGUMENTS`."""
    try:
        return run([str(argument) for argument in arguments])
    except SystemExit as end:
        return int(end.code or 0)
