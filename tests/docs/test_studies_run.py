"""Every study that the documentation names is run by a test, at smoke size; here, if nowhere else."""

from __future__ import annotations

import ast
import importlib
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.docs.code_blocks import IN_PACKAGES, study_lines
from tests.paths import REPO


def smoke_runs(text: str) -> set[str]:
    """Modules whose command line a file of tests calls with --smoke."""
    tree = ast.parse(text)
    mains = dict(_mains(tree))
    return {
        mains[called]
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        and any(isinstance(x, ast.Constant) and x.value == "--smoke" for x in ast.walk(function))
        for node in ast.walk(function)
        if isinstance(node, ast.Call) and (called := ast.unparse(node.func)) in mains
    }


def _mains(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """How `main` of each imported study is called there, and the study."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("studies"):
            for name in node.names:
                own = name.asname or name.name
                if name.name == "main":
                    yield own, f"{node.module}"
                else:
                    yield f"{own}.main", f"{node.module}.{name.name}"


RUN_BY_TESTS = {
    study
    for file in (REPO / "tests").rglob("test_*.py")
    for study in smoke_runs(file.read_text(encoding="utf-8"))
}
NAMED = {words[2]: tuple(words[3:]) for words in map(shlex.split, study_lines())}
OTHERS = [study for study in NAMED if IN_PACKAGES.get(study, study) not in RUN_BY_TESTS]


def test_a_study_that_is_only_imported_or_run_at_full_size_is_not_taken_for_run() -> None:
    text = "from studies import loop\nfrom studies.bench.study import main\n"
    run = "def test():\n    given = ['--out', 'x'{}]\n    assert loop.main(given) == 0\n    main([])\n"
    assert smoke_runs(text + run.format("")) == set()
    found = smoke_runs(text + run.format(", '--smoke'"))
    assert found == {"studies.loop", "studies.bench.study"}


@pytest.mark.parametrize("study", OTHERS)
def test_runs_at_smoke_size(study: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(REPO))
    module = importlib.import_module(IN_PACKAGES.get(study, study))
    assert not module.main([*NAMED[study], "--smoke", "--out", "results"])
    left = {file.name for file in (tmp_path / "results").iterdir() if file.stat().st_size > 0}
    assert "provenance.json" in left
    assert len(left) > 1
