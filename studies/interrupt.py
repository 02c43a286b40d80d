"""How a study runs from the command line: on one BLAS thread, and interrupted in one line.

Its matrices are small: threads of one wait for one another, and take two to eight times as long as
one where the machine has other work. Exit status 130 after an interrupt is what a shell expects of
Ctrl-C; a request to terminate, as of `timeout` or a batch system, is met in the same way.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from typing import Never

from threadpoolctl import threadpool_limits

BAD_INPUT = 2  # as argparse has it
NO_USABLE_RESULT = 3  # the input is in order, and what was asked for cannot be had
INTERRUPTED = 130  # 128 and the number of SIGINT
NOTHING = "nothing was written"
RESUMES = "what was done is kept; the same command goes on from there"


def leave(main: Callable[[], int | None], name: str, told: str = NOTHING) -> Never:
    """Run a study from the command line and end the process with its code.

    Args:
        main: Of the study.
        name: Of the study, for the message.
        told: What an interrupt leaves, in words.
    """
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with threadpool_limits(limits=1):
            code = main()
    except (KeyboardInterrupt, SystemError) as error:
        if not is_interrupt(error):
            raise
        sys.stderr.write(f"\n{name}: interrupted: {told}\n")
        code = INTERRUPTED
    finally:
        signal.signal(signal.SIGTERM, before)
    sys.exit(code)


def is_interrupt(error: BaseException | None) -> bool:
    """Whether it is Ctrl-C, or what compiled code makes of it: a SystemError caused by one."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
