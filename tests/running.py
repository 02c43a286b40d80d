"""A command, run as a user runs it, in this process."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import msgspec

from oed.commands.main import run
from oed.export.model_file import NAME as MODEL
from oed.export.model_record import ModelRecord
from oed.report.folder_lock import STATE
from oed.report.json_file import read_json
from oed.report.records.files import RECORDS
from oed.report.records.record import Record
from oed.report.result_folder import RECORD


def oed(*arguments: object) -> int:
    """Exit status of `oed ARGUMENTS`; what it left is held to its records."""
    words = [str(argument) for argument in arguments]
    try:
        status = run(words)
    except SystemExit as end:
        status = int(end.code or 0)
    if status == 0 and "--out" in words[:-1]:
        for path, record in recorded(Path(words[words.index("--out") + 1])):
            msgspec.convert(read_json(path), record, strict=True)
    return status


def recorded(out: Path) -> Iterator[tuple[Path, type[Record]]]:
    """JSON files that runs left in a folder and below it, with what each of them is.

    Raises:
        KeyError: If a command leaves one that nothing is said of.
    """
    for state in out.rglob(f"{STATE}/{RECORD}"):
        left = json.loads(state.read_text(encoding="utf-8"))
        folder = state.parent.parent
        for name in left["files"]:
            if name.endswith(".json") and (folder / name).is_file():
                record = ModelRecord if name == MODEL else RECORDS[left["command"]][name]
                yield folder / name, record
