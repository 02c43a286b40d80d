"""Where a study may leave its results, asked before the work and not after it."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path


def check_output_folder(folder: Path) -> None:
    """Refuse a folder that results cannot be written to; nothing is left there.

    Raises:
        ValueError: If the path or one above it is a file, or the folder cannot be written.
    """
    try:
        existing = folder.absolute()
        while not existing.exists() and not existing.is_symlink():
            existing = existing.parent
        if not existing.is_dir():
            raise ValueError(f"--out {folder}: {existing} is a file, not a folder")
        # Only writing tells: what a system says it permits misses read-only and special folders.
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        message = f"--out {folder}: cannot be written: {error.strerror}; choose another folder"
        raise ValueError(message) from error


def output_folder(text: str) -> Path:
    """The folder that an option names, as argparse's `type`; one that cannot be written ends it.

    Raises:
        argparse.ArgumentTypeError: As `check_output_folder` refuses.
    """
    folder = Path(text)
    try:
        check_output_folder(folder)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("--out ")) from error
    return folder


def results_folder(study: str, *, smoke: bool) -> Path:
    """Where a study leaves its results if nothing else is said.

    Args:
        study: Name of its folder.
        smoke: Whether it only tries whether it works: that must not replace results.

    Raises:
        ValueError: If it cannot be written.
    """
    folder = Path("out" if smoke else "results") / study
    check_output_folder(folder)
    return folder
