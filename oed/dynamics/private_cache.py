"""Folders for compiled code that only this user can write to, and what may be loaded from them.

Whoever can write to such a folder can have this program run any code: a folder that is somebody
else's, or that others may write to, is left alone, and the code is compiled anew for this run.
"""

from __future__ import annotations

import hashlib
import logging
import os
import stat
from pathlib import Path

logger = logging.getLogger(__name__)

WRITABLE = stat.S_IWGRP | stat.S_IWOTH


def private_folder(name: str) -> Path | None:
    """The cache folder of that name; None where it cannot be had for ourselves alone.

    Args:
        name: Below $XDG_CACHE_HOME/oed, or ~/.cache/oed.
    """
    root = os.environ.get("XDG_CACHE_HOME")
    try:
        above = Path(root) if root else Path.home() / ".cache"
        above.mkdir(parents=True, exist_ok=True)
        for folder in (above / "oed", above / "oed" / name):
            folder.mkdir(mode=0o700, exist_ok=True)
            fault = _fault(folder.lstat(), stat.S_ISDIR)
            if fault:
                logger.warning(
                    "the cache %s %s: nothing is loaded from it (remove it, or chmod 700 it)",
                    folder,
                    fault,
                )
                return None
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home
        logger.warning("no cache for compiled code: %s", error)
        return None
    return above / "oed" / name


def find_whole(folder: Path, key: str, suffix: str) -> Path | None:
    """The file of a key that is ours and whole; one that is damaged is removed.

    Args:
        folder: A private one.
        key: That the file was written under.
        suffix: Of its name.

    Returns:
        None where there is none.
    """
    for path in sorted(folder.glob(f"{key}-*{suffix}")):
        try:
            handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            with os.fdopen(handle, "rb") as file:
                fault = _fault(os.fstat(file.fileno()), stat.S_ISREG)
                is_whole = not fault and path.name == whole_name(key, file.read(), suffix)
        except OSError as error:
            fault, is_whole = f"cannot be read ({error.strerror})", False
        if is_whole:
            return path
        logger.warning("compiled code %s %s: made anew", path, fault or "is damaged")
        path.unlink(missing_ok=True)
    return None


def whole_name(key: str, content: bytes, suffix: str) -> str:
    """The name of a file of that content: its own hash is part of it."""
    return f"{key}-{hashlib.sha256(content).hexdigest()[:32]}{suffix}"


def _fault(state: os.stat_result, is_kind) -> str:  # a function of the stat module
    if not is_kind(state.st_mode):
        return "is of another kind than it should be"
    if state.st_uid != os.getuid():
        return f"belongs to another user (number {state.st_uid})"
    if state.st_mode & WRITABLE:
        return "can be written to by others"
    return ""
