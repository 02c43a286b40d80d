"""What a command says while it works: lines of the logger "oed", which `--quiet` holds back."""

from __future__ import annotations

import logging
import sys
from typing import Any

LOGGER = logging.getLogger("oed")
say = LOGGER.info


class _Handler(logging.StreamHandler):
    """Writes to what is standard output by then: a notebook's cell, or a test, has its own."""

    def __init__(self) -> None:
        logging.Handler.__init__(self)

    @property
    def stream(self) -> Any:  # whatever stands in for it
        return sys.stdout

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: ARG002, N802  # as logging calls it
        """A full disk ends the command in its one line, not in a traceback a line."""
        raise  # noqa: PLE0704  # called while an error is handled


def speak(*, quiet: bool) -> None:
    """Let the lines appear on standard output, or not.

    Args:
        quiet: Whether only what was found and what is wrong is said.
    """
    LOGGER.setLevel(logging.WARNING if quiet else logging.INFO)
    LOGGER.propagate = False
    LOGGER.handlers = [_Handler()]
