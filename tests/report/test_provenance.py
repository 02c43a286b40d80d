import subprocess
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import pytest

from oed.report.json_file import read_json
from oed.report.provenance import Provenance, git_state


@dataclass(frozen=True)
class Config:
    robots: tuple[str, ...] = ("imi_scara",)
    out: Path = Path("results")
    cutoff: float = 14.0


def git(folder: Path, *arguments: str) -> None:
    identity = ["-c", "user.name=t", "-c", "user.email=t@example.org"]
    subprocess.run(["git", *identity, *arguments], cwd=folder, check=True, capture_output=True)


def checkout(folder: Path) -> Path:
    git(folder, "init", "-q")
    package = folder / "oed" / "report"
    package.mkdir(parents=True)
    (package / "code.py").write_text("x = 1\n", encoding="utf-8")
    git(folder, "add", ".")
    git(folder, "commit", "-q", "-m", "first")
    return package


def test_says_what_was_asked_and_where_it_ran(tmp_path: Path) -> None:
    Provenance.collect(Config(), seed=7).write(tmp_path / "provenance.json")
    written = read_json(tmp_path / "provenance.json")
    assert isinstance(written, dict)
    assert written["seed"] == 7
    assert written["configuration"] == {"robots": ["imi_scara"], "out": "results", "cutoff": 14.0}
    assert written["versions"]["numpy"] == version("numpy")
    assert written["cpu"]
    assert written["date"].endswith("+00:00")


def test_refuses_a_configuration_that_is_no_dataclass() -> None:
    with pytest.raises(ValueError, match="dataclass"):
        Provenance.collect({"seed": 1}, seed=1)


def test_refuses_a_configuration_with_nan() -> None:
    with pytest.raises(ValueError, match="cutoff is nan"):
        Provenance.collect(Config(cutoff=float("nan")), seed=1)


def test_a_clean_checkout_is_clean_and_an_edit_makes_it_dirty(tmp_path: Path) -> None:
    package = checkout(tmp_path)
    commit, dirty = git_state(package)
    assert commit is not None
    assert len(commit) == 40
    assert dirty is False
    (package / "code.py").write_text("x = 2\n", encoding="utf-8")
    assert git_state(package) == (commit, True)


def test_results_written_by_the_run_do_not_make_it_dirty(tmp_path: Path) -> None:
    package = checkout(tmp_path)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "runs.csv").write_text("a\n1\n", encoding="utf-8")
    assert git_state(package)[1] is False


def test_another_projects_checkout_is_not_ours(tmp_path: Path) -> None:
    checkout(tmp_path)
    foreign = tmp_path / ".venv" / "oed"
    foreign.mkdir(parents=True)
    assert git_state(foreign) == (None, None)


def test_outside_a_checkout_there_is_no_commit(tmp_path: Path) -> None:
    assert git_state(tmp_path) == (None, None)
