"""How processes of this project end: interrupted in one line, and never after their parent.

Exit status 130 after an interrupt is what a shell expects of Ctrl-C; a request to terminate, as of
`timeout` or a batch system, is met in the same way. Only light modules are imported here: an
interrupt may come while the others load.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Never

INTERRUPTED = 130  # 128 and the number of SIGINT
BAD_INPUT = 2  # as for options that cannot be used
NO_USABLE_RESULT = 3  # the input is in order, and what was asked for cannot be had
NOTHING = "nothing was written"
STEPS = "the steps that were done are kept"
RESUMES = "what was done is kept; the same command goes on from there"
PR_SET_PDEATHSIG = 1  # prctl(2): the signal that a process gets when its parent ends
PARENT = "OED_PARENT"  # environment variable: the process that a command must not outlive
LOOK_EVERY = 1.0  # [s] for the parent, where the system tells nothing of its end


def leave(main: Callable[[], int | None], name: str, told: str = NOTHING) -> Never:
    """Run a command and end the process with its status; see `exit_status`."""
    sys.exit(exit_status(main, name, told))


def exit_status(main: Callable[[], int | None], name: str, told: str = NOTHING) -> int:
    """Run a command: the status that its process ends with, and one line where it cannot go on.

    It runs on one thread of linear algebra, see `oed.one_thread`.

    Args:
        main: The command. A `ValueError`, an `OSError` or an `OedError` ends it in one line.
        name: Of the command, for the message.
        told: What an interrupt leaves, in words.
    """
    # Numerical libraries take seconds to load: not before an interrupt can be met.
    from oed.errors import NoUsableResult, OedError, one_line  # noqa: PLC0415
    from oed.one_thread import on_one_thread  # noqa: PLC0415

    before = {
        number: signal.signal(number, signal.default_int_handler)
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        with unread_output():
            code = on_one_thread(main)()
    except (KeyboardInterrupt, SystemError, ImportError) as error:
        if not is_interrupt(error):
            raise
        sys.stderr.write(f"\n{name}: interrupted: {told}\n")
        code = INTERRUPTED
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"{name}: {one_line(error)}\n")
        code = NO_USABLE_RESULT if isinstance(error, NoUsableResult) else BAD_INPUT
    except MemoryError as error:
        sys.stderr.write(f"{name}: not enough memory: {one_line(error) or 'ask for less'}\n")
        code = NO_USABLE_RESULT
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    return code or 0


class _Output:
    """A stream that goes on when its reader has gone: results matter more than the words on them."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            self._drop()
            return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except BrokenPipeError:
            self._drop()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _drop(self) -> None:
        """Send the rest nowhere, what the interpreter writes at its end with it."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)


@contextmanager
def unread_output() -> Iterator[None]:
    """Meanwhile nothing fails because nobody reads the output any more, as in `oed identify … | head`."""
    before = sys.stdout
    sys.stdout = _Output(before)  # pyright: ignore[reportAttributeAccessIssue]  # it has what print and logging use
    try:
        yield
        sys.stdout.flush()
    finally:
        sys.stdout = before


def is_interrupt(error: BaseException | None) -> bool:
    """Whether it is Ctrl-C, or what compiled code, or its loading, makes of it: an error caused by one."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def end_quietly_while_loading(name: str) -> None:
    """Until `leave` takes over, an interrupt ends the process in one line: nothing was begun.

    Args:
        name: Of the command.
    """

    def end(*_: object) -> None:
        os.write(2, f"\n{name}: interrupted: {NOTHING}\n".encode())
        os._exit(INTERRUPTED)

    signal.signal(signal.SIGINT, end)
    signal.signal(signal.SIGTERM, end)
    if parent := os.environ.pop(PARENT, ""):
        end_with_parent(int(parent), quiet=False)


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Processes begun meanwhile are not interrupted until they call `end_with_parent`.

    This one is, once the block has ended.
    """
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def end_with_parent(parent: int | None = None, *, quiet: bool = True) -> None:
    """Called by a child process: it ends when its parent does, killed or not, and quietly.

    Args:
        parent: Process number of the parent, known before the child was begun: a parent that is
            gone already is no longer what `getppid` tells. None where that is what there is.
        quiet: Whether an interrupt ends it without a word.
    """
    if quiet:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    parent = os.getppid() if parent is None else parent
    told = sys.platform == "linux" and not ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
    if not told:
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def ends_with_this() -> dict[str, str]:
    """The environment in which a command of this project ends when this process does."""
    return {**os.environ, PARENT: str(os.getpid())}


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_EVERY)
    os._exit(1)
