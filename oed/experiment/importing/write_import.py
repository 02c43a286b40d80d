"""A data set that was made of logs, in a folder: whole, or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from oed.experiment.importing.import_log import Import
from oed.experiment.importing.manifest_text import manifest_text
from oed.experiment.manifest import MANIFEST
from oed.experiment.write_dataset import check_new_folder, write_robot


def write_import(found: Import, out: str | Path, *, reference: bool = False) -> None:
    """Write the data set's folder: all of it, or nothing.

    The robot's file is copied, and so are the logs unless they are referred to where they are.

    Raises:
        ValueError: If the folder is in use.
    """
    target = Path(out)
    check_new_folder(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.name}-") as temporary:
            folder = Path(temporary) / target.name
            folder.mkdir()
            place_import(found, folder, target, reference=reference)
            folder.rename(target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OSError(f"--out {target}: {reason}: nothing was written") from error


def place_import(found: Import, folder: Path, target: Path, *, reference: bool = False) -> None:
    """Write the data set's files into a folder that is there and empty.

    Args:
        found: To write.
        folder: To write to.
        target: Folder that the files are moved to when all are whole.
        reference: Whether logs stay where they are, instead of being copied.
    """
    names = _placed(found.logs, folder, target, reference=reference)
    said = write_robot(found.dataset.robot, folder, target)
    content = {}
    for key, value in found.content.items():  # in an order to read
        content |= said if key == "robot" else {key: value}
    content["recording"] = [
        entry | {"file": names[entry["file"]]}
        for entry in found.content["recording"]  # type: ignore[attr-defined]
    ]
    text = manifest_text(content, found.notes)
    (folder / MANIFEST).write_text(text, encoding="utf-8")


def _placed(
    logs: Sequence[Path], folder: Path, target: Path, *, reference: bool
) -> dict[object, str]:
    """What each log is called in the data set, by where it is now; copied unless referred to."""
    names: dict[object, str] = {}
    for i, log in enumerate(logs):
        real = log.resolve()
        if reference:
            names[str(real)] = os.path.relpath(real, target.resolve())
            continue
        name = real.name if real.name not in names.values() else f"{i + 1}-{real.name}"
        if real.is_dir():
            shutil.copytree(real, folder / name)
        else:
            shutil.copyfile(real, folder / name)
        names[str(real)] = name
    return names
