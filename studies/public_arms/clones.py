"""Local clones: which is of which repository, and at which commit it stands."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

SHORT = 12  # digits of a commit


def clone_of(marker: str, clones: Sequence[Path]) -> Path | None:
    """The clone that has a file; None if none has.

    Args:
        marker: The file, by its path in the repository.
        clones: Clones, or folders that hold some.

    Raises:
        ValueError: If a folder is not there.
    """
    for folder in clones:
        if not folder.is_dir():
            raise ValueError(f"--repo {folder}: no such folder")
    every = [clone for folder in clones for clone in (folder, *sorted(folder.iterdir()))]
    return next((clone for clone in every if (clone / marker).is_file()), None)


def commit_of(clone: Path) -> str:
    """At which a clone stands; "no commit" of a folder that is no clone."""
    command = ["git", "-C", str(clone), "rev-parse", "HEAD"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603  a fixed command
    return run.stdout.strip()[:SHORT] if run.returncode == 0 else "no commit"
