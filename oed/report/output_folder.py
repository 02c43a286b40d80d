"""Where a study may leave its results, asked before the work and not after it."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]


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


def named_folder(text: str) -> Path:
    """The folder that an option names, as argparse's `type`, for one that is judged later.

    Raises:
        argparse.ArgumentTypeError: If the text is empty, which a path takes for the folder at hand.
    """
    if not text.strip():
        raise argparse.ArgumentTypeError("is empty; name a folder")
    return Path(text)


def output_folder(text: str) -> Path:
    """The folder that an option names, as argparse's `type`; one that cannot be written ends it.

    Raises:
        argparse.ArgumentTypeError: As `check_output_folder` refuses, or if the text is empty.
    """
    folder = named_folder(text)
    try:
        check_output_folder(folder)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("--out ")) from error
    return folder


def results_folder(study: str, *, smoke: bool, own_data: bool = False) -> Path:
    """Where a study leaves its results if nothing else is said.

    Args:
        study: Name of its folder.
        smoke: Whether it only tries whether it works: that must not replace results.
        own_data: Whether it works on a user's data: these are no results of this project.

    Raises:
        ValueError: If it cannot be written.
    """
    folder = Path("out" if smoke or own_data else "results") / study
    check_output_folder(folder)
    return folder


def is_committed(folder: Path) -> bool:
    """Whether it lies in the checkout's `results/`: git keeps whatever a run replaces there."""
    return (CHECKOUT / ".git").exists() and folder.resolve().is_relative_to(CHECKOUT / "results")


def is_scratch(folder: Path) -> bool:
    """Whether it lies in the checkout's `out/`, which holds what runs wrote and nothing else."""
    return (CHECKOUT / ".git").exists() and folder.resolve().is_relative_to(CHECKOUT / "out")
