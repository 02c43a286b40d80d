"""Where a ROS package lies: in a workspace that is set up, or around the file that names it.

Standard library alone: the reader of xacro runs this in a process of its own.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path


def find_package(name: str, near: Path) -> Path | None:
    """The folder of a package.

    Looked for in ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, then among the folders above `near` and
    those beside them: one that is called after the package, or whose package.xml gives its name.

    Args:
        name: Of the package.
        near: The file that names it.

    Returns:
        None where it is not found.
    """
    return next(find_packages(name, near), None)


def find_packages(name: str, near: Path) -> Iterator[Path]:
    """All folders that `find_package` would take, the first first: a package may be in parts."""
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", name) or name in (".", ".."):
        return
    for folder in _candidates(name, near):
        if folder.is_dir() and (folder.name == name or package_name(folder) == name):
            yield folder


def read_packages(words: Sequence[str]) -> dict[str, Path]:
    """Folders of packages by name, from words such as "arm_description=/home/me/arm".

    Raises:
        ValueError: If a word is no such pair, or its folder is not there.
    """
    found = {}
    for word in words:
        name, is_pair, folder = word.partition("=")
        if not (is_pair and name and folder):
            raise ValueError(f"--package {word}: expected NAME=DIR")
        if not Path(folder).is_dir():
            raise ValueError(f"--package {word}: no such folder")
        found[name] = Path(folder).absolute()
    return found


def package_name(folder: Path) -> str | None:
    """The name in a folder's package.xml; None where there is none."""
    description = folder / "package.xml"
    if not description.is_file():
        return None
    found = re.search(r"<name>\s*([^<\s]+)\s*</name>", description.read_text(errors="replace"))
    return found.group(1) if found else None


def _candidates(name: str, near: Path) -> Iterator[Path]:
    for root in _listed("ROS_PACKAGE_PATH"):
        yield root / name
        yield root
    for prefix in _listed("AMENT_PREFIX_PATH"):
        yield prefix / "share" / name
    for folder in near.resolve().parents:
        yield folder / name
        yield folder


def _listed(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]
