"""Every command ends with the status that the documentation lists, and says why in one line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from oed.commands.main import COMMANDS
from oed.dynamics import cross_check
from oed.process_end import BAD_INPUT, INTERRUPTED, NO_USABLE_RESULT
from tests.paths import REPO
from tests.running import oed

DISAGREES = 1
# What each command reads, by a name that nothing has, or a file that is nothing of the kind.
READ = {
    "import": ("{}", "--robot", "builtin:imi_scara"),
    "check": ("{}",),
    "design": ("--robot", "{}"),
    "identify": ("{}",),
    "feasible": ("{}",),
    "payload": ("--loaded", "{}"),
    "gains": ("--bare", "{}", "--loaded", "{}2"),
    "diagnose": ("{}",),
    "calibrate": ("{}",),
    "export": ("{}", "--to", "c"),
    "cross-check": ("builtin:imi_scara", "{}"),
}
ALL = {**READ, "demo": ()}


def test_the_documentation_lists_these() -> None:
    page = (REPO / "docs/reference/commands.md").read_text(encoding="utf-8")
    listed = [int(status) for status in re.findall(r"^\| (\d+) \|", page, re.MULTILINE)]
    assert listed == [0, DISAGREES, BAD_INPUT, NO_USABLE_RESULT, INTERRUPTED]
    assert set(ALL) == set(COMMANDS)


@pytest.mark.parametrize("kind", ["nothing", "words", "folder"])
@pytest.mark.parametrize("command", READ)
def test_input_that_cannot_be_used(
    command: str, kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = tmp_path / "given.csv"
    if kind == "words":
        given.write_text("these are words\nand no more\n")
    elif kind == "folder":
        given.mkdir()
    out = tmp_path / "out"
    words = [word.format(given) for word in READ[command]]
    assert oed(command, *words, "--out", out) == BAD_INPUT
    told = capsys.readouterr().err
    assert told.startswith(f"oed {command}: ")
    assert told.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize("command", ALL)
def test_a_folder_with_other_files(
    command: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "thesis.tex").write_text("mine")
    words = [word.format("../given.csv") for word in ALL[command]]
    assert oed(command, *words, "--out", ".") == BAD_INPUT
    assert capsys.readouterr().err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize("command", ALL)
def test_options_that_do_not_exist_and_help(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert oed(command, "--no-such-option") == BAD_INPUT
    assert capsys.readouterr().err.count("\n") == 1
    assert oed(command, "--help") == 0


def test_what_should_agree_and_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    given = ["cross-check", "builtin:imi_scara", "--states", 5, "--quiet"]
    assert oed(*given) == 0
    monkeypatch.setattr(cross_check, "AGREEMENT", 0.0)
    assert oed(*given) == DISAGREES
