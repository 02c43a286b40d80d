"""Where a study may leave its results, asked before the work and not after it."""

from __future__ import annotations

import os
from pathlib import Path


def check_output_folder(folder: Path) -> None:
    """Refuse a folder that results cannot be written to; nothing is made.

    Raises:
        ValueError: If the path or one above it is a file, or the folder cannot be written.
    """
    existing = folder.absolute()
    while not existing.exists() and not existing.is_symlink():
        existing = existing.parent
    if not existing.is_dir():
        raise ValueError(f"--out {folder}: {existing} is a file, not a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise ValueError(f"--out {folder}: no permission to write in {existing}")


def results_folder(study: str, *, smoke: bool) -> Path:
    """Where a study leaves its results if nothing else is said.

    Args:
        study: Name of its folder.
        smoke: Whether it only tries whether it works: that must not replace results.
    """
    return Path("out" if smoke else "results") / study
