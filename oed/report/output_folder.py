"""Where a study may leave its results, asked before the work and not after it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from oed.report.folder_lock import RECORD, STATE

OF_A_DISK = "lost+found"  # a folder in which a file system keeps what it mends
CHECKOUT = Path(__file__).resolve().parents[2]


def check_output_folder(folder: Path) -> None:
    """Refuse a folder that results cannot be written to; nothing is left there.

    Raises:
        ValueError: If the path or one above it is a file or a link to nothing, or the folder cannot be
            written.
    """
    try:
        existing = folder.absolute()
        while not existing.exists() and not existing.is_symlink():
            existing = existing.parent
        if existing.is_symlink() and not existing.exists():
            raise ValueError(f"--out {folder}: {existing} is a link to nothing")
        if not existing.is_dir():
            raise ValueError(f"--out {folder}: {existing} is a file, not a folder")
        # Only writing tells: what a system says it permits misses read-only and special folders.
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        message = f"--out {folder}: cannot be written: {error.strerror}; choose another folder"
        raise ValueError(message) from error


def is_committed(folder: Path) -> bool:
    """Whether it lies in the checkout's `results/`: git keeps whatever a run replaces there."""
    return (CHECKOUT / ".git").exists() and folder.resolve().is_relative_to(CHECKOUT / "results")


def is_scratch(folder: Path) -> bool:
    """Whether it lies in the checkout's `out/`, which holds what runs wrote and nothing else."""
    return (CHECKOUT / ".git").exists() and folder.resolve().is_relative_to(CHECKOUT / "out")


def of_others(folder: Path) -> list[str]:
    """What lies in a folder and no run left there."""
    if not folder.is_dir():
        return []
    return sorted(entry.name for entry in folder.iterdir() if _is_of_others(entry))


def _is_of_others(entry: Path) -> bool:
    """Whether it is a file, or a folder that holds one, at whatever depth, and is no run's."""
    if entry.name in (STATE, OF_A_DISK):
        return False
    if entry.is_symlink() or not entry.is_dir():
        return True
    try:
        # Steps of a longer run have folders of their own, which are there before its own record.
        is_a_run_s = (entry / STATE / RECORD).is_file()
        return not is_a_run_s and any(map(_is_of_others, entry.iterdir()))
    except PermissionError:
        return True
