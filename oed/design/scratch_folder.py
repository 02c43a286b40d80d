"""A temporary folder that goes with its process: where that is killed, the next one removes it."""

from __future__ import annotations

import fcntl
import os
import shutil
import stat
import tempfile
import weakref
from dataclasses import dataclass
from pathlib import Path

LOCK = "lock"
NEW_LOCK = "new-lock"


@dataclass(frozen=True, eq=False)
class ScratchFolder:
    """A folder that is deleted when nobody refers to it.

    The kernel holds its lock for as long as the process lives, however that ends: a lock that can be
    had proves that nobody is left who needs the folder.

    Attributes:
        path: Of the folder.
        handle: Of its lock.
    """

    path: Path
    handle: int

    def __post_init__(self) -> None:
        # A TemporaryDirectory would do the same, and warn of it.
        weakref.finalize(self, _remove, self.path, self.handle)

    @classmethod
    def new(cls, prefix: str) -> ScratchFolder:
        """A new one; those of this user's processes that are dead are removed.

        Args:
            prefix: Of its name, and of theirs.
        """
        for other in Path(tempfile.gettempdir()).glob(f"{prefix}*"):
            _remove_if_dead(other)
        path = Path(tempfile.mkdtemp(prefix=prefix))
        handle = os.open(path / NEW_LOCK, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        fcntl.flock(handle, fcntl.LOCK_EX)
        # Held before it has the name that others look for.
        (path / NEW_LOCK).rename(path / LOCK)
        return cls(path, handle)


def _remove_if_dead(folder: Path) -> None:
    try:
        state = folder.lstat()
        if state.st_uid != os.getuid() or not stat.S_ISDIR(state.st_mode):
            return
        handle = os.open(folder / LOCK, os.O_RDWR | os.O_NOFOLLOW)
    except OSError:  # it is gone meanwhile, or is not locked in this way
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # its process lives
        os.close(handle)
        return
    _remove(folder, handle)


def _remove(folder: Path, handle: int) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    os.close(handle)
