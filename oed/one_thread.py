"""Linear algebra on one thread: the matrices are small.

Threads of one product wait for one another, which takes two to eight times as long where the
machine has other work.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

GivenT = ParamSpec("GivenT")
FoundT = TypeVar("FoundT")


def on_one_thread(work: Callable[GivenT, FoundT]) -> Callable[GivenT, FoundT]:
    """The same work, with one thread for each BLAS that is loaded when it begins."""

    @wraps(work)
    def limited(*args: GivenT.args, **kwargs: GivenT.kwargs) -> FoundT:
        with threadpool_limits(limits=1):
            return work(*args, **kwargs)

    return limited
