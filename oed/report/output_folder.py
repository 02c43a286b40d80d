"""Where a study may leave its results, asked before the work and not after it."""

from __future__ import annotations

import tempfile
from pathlib import Path

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
