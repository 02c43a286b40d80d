"""Stages of a long study, kept on disk until something that they depend on changes."""

from __future__ import annotations

import dataclasses
import hashlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import numpy as np

ROOT = Path(__file__).resolve().parents[2]


T = TypeVar("T")  # a frozen dataclass whose fields are all arrays


@dataclass(frozen=True)
class StageCache:
    """Keeps arrays under a key made of settings, of what came before, and of the code.

    Attributes:
        folder: Where the files lie.
    """

    folder: Path

    def key(self, name: str, parts: Sequence[object], sources: Sequence[str]) -> str:
        """Hash of the stage's name, its settings, the keys of what it uses, and the code.

        Args:
            name: Of the stage.
            parts: Settings and keys; their `repr` must show all that matters.
            sources: Folders and files, relative to the repository, whose code decides.
        """
        digest = hashlib.sha256(name.encode())
        digest.update(code_hash(tuple(sources)).encode())
        for part in parts:
            digest.update(repr(part).encode())
        return digest.hexdigest()[:24]

    def get(self, name: str, key: str, kind: type[T], compute: Callable[[], T]) -> T:
        """The stage's result: read if it is there, else computed and kept."""
        file = self.folder / f"{name}-{key}.npz"
        fields = [f.name for f in dataclasses.fields(kind)]  # type: ignore[arg-type]
        if file.is_file():
            with np.load(file, allow_pickle=False) as kept:
                print(f"  {name}: unchanged, read back", flush=True)
                return kind(**{f: kept[f] for f in fields})
        started = time.perf_counter()
        print(f"  {name} …", flush=True)
        result = compute()
        self.folder.mkdir(parents=True, exist_ok=True)
        scratch = file.with_suffix(".part.npz")
        np.savez_compressed(scratch, **{f: getattr(result, f) for f in fields})
        scratch.replace(file)
        print(f"  {name}: {time.perf_counter() - started:.1f} s", flush=True)
        return result


@lru_cache
def code_hash(sources: tuple[str, ...]) -> str:
    """Hash of all Python files in these folders, and of these files."""
    digest = hashlib.sha256()
    for source in sources:
        place = ROOT / source
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(file.relative_to(ROOT).as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()
