"""How a study ends, from where its scripts take it; `oed.process_end` holds it."""

from oed.process_end import (
    BAD_INPUT,
    INTERRUPTED,
    NO_USABLE_RESULT,
    NOTHING,
    RESUMES,
    is_interrupt,
    leave,
)

__all__ = [
    "BAD_INPUT",
    "INTERRUPTED",
    "NOTHING",
    "NO_USABLE_RESULT",
    "RESUMES",
    "is_interrupt",
    "leave",
]
