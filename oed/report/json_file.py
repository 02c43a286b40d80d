"""JSON files that are whole or not there, with NumPy values written as plain ones."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import tempfile
from collections.abc import Mapping
from datetime import date, datetime
from pathlib import Path
from typing import Any

import numpy as np

NOT_FINITE = "not_finite"


def plain_value(value: object, place: str = "$") -> object:
    """A value in the types that JSON has.

    Args:
        value: Numbers, text, None, NumPy scalars and arrays, paths, dates, dataclasses,
            mappings with text keys, sequences and sets of these. Sets come out sorted.
        place: Where the value stands, for the error message.

    Raises:
        ValueError: If a number is NaN or infinite, which JSON cannot say.
        TypeError: If a type or a key has no counterpart in JSON.
    """
    nulled: dict[str, str] = {}
    plain = _plain(value, place, nulled)
    if nulled:
        where, number = next(iter(nulled.items()))
        raise ValueError(f"{where} is {number}: JSON has no such number; write null instead")
    return plain


def write_json(path: str | Path, value: object) -> None:
    """Write a value as indented JSON.

    JSON has neither NaN nor infinities: they become null, and an object that holds any says
    under `not_finite` where each stood and what it was. Work that is done is not lost for them.

    Raises:
        ValueError: If there is such a number in what is no object and cannot say so.
        TypeError: As `plain_value`; nothing is written.
    """
    nulled: dict[str, str] = {}
    plain = _plain(value, "$", nulled)
    if nulled:
        if not isinstance(plain, dict):
            place, number = next(iter(nulled.items()))
            raise ValueError(f"{place} is {number}: JSON has no such number; write null instead")
        plain = {**plain, NOT_FINITE: nulled}
    text = json.dumps(plain, indent=2, ensure_ascii=False, allow_nan=False)
    write_atomically(path, text + "\n")


def read_json(path: str | Path) -> Any:
    """The value that a JSON file holds.

    Raises:
        ValueError: If the file is not JSON, is nested too deeply, or holds NaN or an infinity.
    """
    text = Path(path).read_text(encoding="utf-8")
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except RecursionError as error:
        raise ValueError(f"{path}: is nested too deeply") from error


def write_atomically(path: str | Path, text: str) -> None:
    """Write a text file so that a reader sees the old or the new one, never a part.

    Folders on the way are made. The temporary file lies beside the target: a rename is
    only atomic within one file system.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    part = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        # mkstemp makes files private; a result is for everyone that the umask allows.
        umask = os.umask(0)
        os.umask(umask)
        part.chmod(0o666 & ~umask)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _plain(value: object, place: str, nulled: dict[str, str]) -> object:
    """As `plain_value`, with None for each number that JSON lacks, noted in `nulled`."""
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            nulled[place] = str(float(value))
            return None
        return float(value)
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(value.tolist(), place, nulled)
    if isinstance(value, (Path, datetime, date)):
        return str(value) if isinstance(value, Path) else value.isoformat()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        return _plain(fields, place, nulled)
    if isinstance(value, Mapping):
        return {_key(k, place): _plain(v, f"{place}.{k}", nulled) for k, v in value.items()}
    if isinstance(value, (set, frozenset)):
        value = sorted(value)
    if isinstance(value, (list, tuple)):
        return [_plain(v, f"{place}[{i}]", nulled) for i, v in enumerate(value)]
    raise TypeError(f"{place} is a {type(value).__name__}, which JSON has no type for")


def _key(key: object, place: str) -> str:
    if not isinstance(key, str):
        raise TypeError(f"{place} has the key {key!r}: JSON has text keys only")
    return key


def _refuse_constant(constant: str) -> object:
    raise ValueError(f"holds {constant}, which is not JSON")
