"""Stages of a long study, kept on disk until something that they depend on changes."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import io
import tempfile
import time
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from jaxtyping import Shaped
from numpy import ndarray

from oed.errors import OedError
from oed.report.code_digest import code_digest
from studies.case_runner import CaseRunner, CaseT, Outcome, RowFile, is_failed

Arrays = Mapping[str, Shaped[ndarray, "..."]]
T = TypeVar("T")  # a frozen dataclass whose fields are all arrays


@dataclass(frozen=True)
class StageCache:
    """Keeps arrays under a key made of settings, of what came before, and of the code.

    Attributes:
        folder: Where the files lie.
        workers: Processes on this machine, for stages of many cases.
        scheduler: Address of a Dask scheduler that does these instead.
    """

    folder: Path
    workers: int = 1
    scheduler: str | None = None

    def key(self, name: str, parts: Sequence[object], modules: Sequence[str]) -> str:
        """Hash of the stage's name, its settings, the keys of what it uses, and the code.

        Args:
            name: Of the stage.
            parts: Settings and keys; their `repr` must show all that matters.
            modules: Dotted names of those that do the work; what they import counts as well.
        """
        digest = hashlib.sha256(name.encode())
        digest.update(code_digest(*modules).encode())
        for part in parts:
            digest.update(repr(part).encode())
        return digest.hexdigest()[:24]

    def get(self, name: str, key: str, kind: type[T], compute: Callable[[], T]) -> T:
        """The stage's result: read if it is there whole, else computed and kept."""
        file = self.folder / f"{name}-{key}.npz"
        fields = [f.name for f in dataclasses.fields(kind)]  # type: ignore[arg-type]
        kept = _read_back(file, kind, fields)
        if kept is not None:
            print(f"  {name}: unchanged, read back", flush=True)
            return kept
        started = time.perf_counter()
        print(f"  {name} …", flush=True)
        result = compute()
        self.folder.mkdir(parents=True, exist_ok=True)
        # Of this run alone: another may be at the same stage.
        with tempfile.TemporaryDirectory(dir=self.folder, prefix=f".{name}-") as scratch:
            part = Path(scratch) / file.name
            np.savez_compressed(part, **{f: getattr(result, f) for f in fields})
            part.replace(file)
        print(f"  {name}: {time.perf_counter() - started:.1f} s", flush=True)
        return result

    def each(
        self,
        name: str,
        key_columns: tuple[str, ...],
        work: Callable[[CaseT], Outcome],
        cases: Sequence[CaseT],
    ) -> list[Arrays]:
        """What the cases of a stage of many give, case by case; those that are done stay.

        Args:
            name: Of the stage.
            key_columns: Names of what a case's key holds.
            work: Ends with `packed`; other processes have to find it.
            cases: All.

        Raises:
            OedError: If one failed: the stage lacks it.
        """
        rows = RowFile(self.folder / f"{name}.csv", key_columns, ("status", "arrays"))
        CaseRunner(work, rows, name).run(cases, workers=self.workers, scheduler=self.scheduler)
        found = rows.rows_of(case.key for case in cases)
        if failed := [row["status"] for row in found if is_failed(row)]:
            raise OedError(f"{rows.path}: {len(failed)} of {len(cases)} {failed[0]}")
        return [_unpacked(row["arrays"]) for row in found]


def packed(arrays: Arrays) -> Outcome:
    """The line of a case that gives arrays, every digit kept."""
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=False, **arrays)
    return {"status": "done", "arrays": base64.b64encode(stream.getvalue()).decode("ascii")}


def _unpacked(text: str) -> Arrays:
    with np.load(io.BytesIO(base64.b64decode(text)), allow_pickle=False) as kept:
        return dict(kept)


def _read_back(file: Path, kind: type[T], fields: Sequence[str]) -> T | None:
    """What a file holds; None where there is none that is whole."""
    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as kept:
            return kind(**{f: kept[f] for f in fields})
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, EOFError, TypeError, zipfile.BadZipFile) as error:
        print(f"  {file} cannot be read back ({error}) and is made anew", flush=True)
        return None
