"""Shape and type annotations of the package, enforced at each function's first calls.

A search calls the same functions a hundred thousand times, and to check all of that would take
longer than the search. So a function is checked at its first calls in every file of tests.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial, wraps
from typing import Any

import jaxtyping

CALLS = 25  # of a function that are checked in a file of tests
WRAPPING = 20  # of these that it takes to wrap a function within another: milliseconds

wrap = jaxtyping.jaxtyped
checked: Counter[int] = Counter()


def check_first_calls(modules: Sequence[str]) -> None:
    """Have the functions of modules that are yet to be imported checked."""
    jaxtyping.jaxtyped = _jaxtyped
    jaxtyping.install_import_hook(modules, "beartype.beartype")


def begin_anew() -> None:
    """Check every function's next calls, as in a new file of tests."""
    checked.clear()


def _jaxtyped(target: Any = None, **how: Any) -> Any:
    """What the import hook puts around functions, in the place of jaxtyping's own."""
    if target is None:
        return partial(_jaxtyped, **how)
    if not inspect.isclass(target):
        return _at_first(target, **how)
    if dataclasses.is_dataclass(target) and "__init__" in vars(target):
        target.__init__ = _at_first(target.__init__, **how)
    return target


def _at_first(function: Callable[..., Any], **how: Any) -> Callable[..., Any]:
    code = id(function.__code__)  # which lives as long as its module, and is dear to hash
    if "<locals>" in function.__qualname__:  # made whenever the function around it is called
        if checked[code] >= CALLS:
            return function
        checked[code] += WRAPPING
    strict: Callable[..., Any] | None = None

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        nonlocal strict
        if checked[code] >= CALLS:
            return function(*args, **kwargs)
        checked[code] += 1
        if strict is None:  # not before: most of the package is never called by one file of tests
            strict = wrap(function, **how)
        return strict(*args, **kwargs)

    return call
