"""Change one line at a time and see whether the nearest tests fail: `make mutants`.

A survivor is a line behind a claim that no test holds. Runs in a copy; the checkout is untouched.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tests.mutants.mutant import LISTED, Mutant, mutated
from tests.paths import REPO

COPIED = ("oed", "studies", "tests", "docs", "pyproject.toml", "README.md")
PATIENCE = 300.0  # [s] for a file of tests: a change may make a loop endless


def main(words: list[str]) -> int:
    """Run the mutants whose claim holds one of the words, all if there is none; 1 if one survives."""
    chosen = [m for m in LISTED if not words or any(word in m.claim for word in words)]
    survivors = []
    with tempfile.TemporaryDirectory() as folder:
        copy = _copy(Path(folder))
        every = sorted({test for mutant in chosen for test in mutant.tests})
        if not _passes(every, copy):
            print(f"the tests fail as they are, without any change: {' '.join(every)}")
            return 1
        for mutant in chosen:
            survived = _survives(mutant, copy)
            print(f"{'SURVIVED' if survived else 'killed  '}  {mutant.claim}", flush=True)
            survivors += [mutant.claim] if survived else []
    print(f"{len(chosen) - len(survivors)} of {len(chosen)} killed")
    return 1 if survivors else 0


def _copy(folder: Path) -> Path:
    copy = folder / "project"
    copy.mkdir()
    for name in COPIED:
        source = REPO / name
        if source.is_dir():
            shutil.copytree(source, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, copy / name)
    beside = REPO.parent / "shared"
    if beside.exists():
        (folder / "shared").symlink_to(beside.resolve())
    return copy


def _survives(mutant: Mutant, copy: Path) -> bool:
    file = copy / mutant.file
    sound = file.read_text(encoding="utf-8")
    file.write_text(mutated(mutant, sound), encoding="utf-8")
    try:
        return _passes(mutant.tests, copy)
    finally:
        file.write_text(sound, encoding="utf-8")


def _passes(tests: Sequence[str], copy: Path) -> bool:
    asked = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    patience = PATIENCE * len(tests)
    try:
        done = subprocess.run(
            asked, cwd=copy, env=environment, timeout=patience, capture_output=True, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
