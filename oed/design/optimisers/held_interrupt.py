"""Ctrl-C, or a request to terminate, while compiled code runs that would take it for a fault."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@dataclass
class HeldInterrupt:
    """Whether an interrupt came since it is held."""

    came: bool = False


@contextmanager
def hold_interrupt() -> Iterator[HeldInterrupt]:
    """Hold interrupts until the block ends, and let them interrupt there.

    CasADi's solvers ask whether one came, which clears it, and go on as after an evaluation that
    failed. Those signals are held for which Python's own handler would raise KeyboardInterrupt,
    in the main thread; a study asks for that of SIGTERM too.

    Raises:
        KeyboardInterrupt: At the end of the block, if an interrupt came in it.
    """
    held = HeldInterrupt()
    is_main = threading.current_thread() is threading.main_thread()
    taken = [s for s in SIGNALS if signal.getsignal(s) is signal.default_int_handler]
    if not is_main or not taken:
        yield held
        return

    def note(*_: object) -> None:
        held.came = True

    for number in taken:
        signal.signal(number, note)
    try:
        yield held
    finally:
        for number in taken:
            signal.signal(number, signal.default_int_handler)
        if held.came:
            raise KeyboardInterrupt
