"""Loops over time that Numba compiles, kept between runs where nobody else can write to them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import numba
from numba.core import config
from numba.core.caching import FunctionCache

from oed.dynamics.private_cache import private_folder

logger = logging.getLogger(__name__)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function at its first call, or load what was compiled of it before.

    Numba unpickles what it finds in its cache, by default beside the source or wherever
    NUMBA_CACHE_DIR says: here it is a folder that was checked.
    """
    folder = private_folder("numba")
    if folder is None:
        return numba.njit(function)
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)  # read when the function is decorated
    try:
        compiled = numba.njit(function)
        compiled._cache = _WholeCache(function)  # noqa: SLF001  # as Dispatcher.enable_caching does
    finally:
        config.CACHE_DIR = before
    return compiled


class _WholeCache(FunctionCache):
    """A cache that is emptied where it is damaged; Numba's own would end the program."""

    def load_overload(self, sig: object, target_context: object) -> object:
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # noqa: BLE001  # unpickling damage may raise anything
            logger.warning("compiled code in %s is damaged (%r): made anew", self.cache_path, error)
            self.flush()
            return None
