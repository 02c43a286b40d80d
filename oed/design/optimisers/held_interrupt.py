"""Ctrl-C while compiled code runs that would take it for a failed evaluation."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass
class HeldInterrupt:
    """Whether Ctrl-C was pressed since it is held."""

    came: bool = False


@contextmanager
def hold_interrupt() -> Iterator[HeldInterrupt]:
    """Hold Ctrl-C until the block ends, and let it interrupt there.

    CasADi's solvers ask whether it was pressed, which clears it, and go on as after an
    evaluation that failed. It is held only where Python's own handler would run: in the main
    thread, without another handler.

    Raises:
        KeyboardInterrupt: At the end of the block, if Ctrl-C was pressed in it.
    """
    held = HeldInterrupt()
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield held
        return

    def note(*_: object) -> None:
        held.came = True

    signal.signal(signal.SIGINT, note)
    try:
        yield held
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if held.came:
            raise KeyboardInterrupt
