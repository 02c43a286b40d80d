"""What a command says while it works: lines of the logger "oed", which `--quiet` holds back."""

from __future__ import annotations

import logging
import sys

LOGGER = logging.getLogger("oed")
say = LOGGER.info


def speak(*, quiet: bool) -> None:
    """Let the lines appear on standard output, or not.

    Args:
        quiet: Whether only what was found and what is wrong is said.
    """
    LOGGER.setLevel(logging.WARNING if quiet else logging.INFO)
    LOGGER.propagate = False
    LOGGER.handlers = [logging.StreamHandler(sys.stdout)]
