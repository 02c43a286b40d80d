"""Every command line that the documentation shows is one that the commands accept."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from oed.commands.main import COMMANDS, configuration_of
from tests.docs.code_blocks import IN_PACKAGES, blocks, command_words, pages, study_lines
from tests.paths import REPO
from tests.running import oed

LINES = sorted(
    {
        line.strip()
        for page in pages()
        for block in blocks(page, "bash")
        for line in block.splitlines()
        if line.strip()
    }
    | set(study_lines())
)


class Parsed(Exception):  # it ends a command that was only to be parsed
    pass


@pytest.mark.parametrize("line", LINES)
def test_is_accepted(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = command_words(line)
    monkeypatch.chdir(tmp_path)
    for model in (word for word in words if word.endswith("model.json")):
        Path(model).parent.mkdir()
        Path(model).touch()  # an earlier line of the page has left it
    if words[:2] == ["oed", "--tyro-write-completion"]:
        script = tmp_path / Path(words[3]).name
        assert oed(*words[1:3], script) == 0
        assert "--sign-width" in script.read_text()
    elif words[0] == "oed":
        assert type(configuration_of(words[1:])) is COMMANDS[words[1]][0]
    elif words[:2] == ["python", "-m"]:
        _accepted_by_study(words[2], words[3:], monkeypatch)
    elif words[0] == "make":
        targets = re.findall(r"^(\w+):", (REPO / "Makefile").read_text(), re.MULTILINE)
        assert words[1] in targets
    else:
        assert words == ["pip", "install", ".[ros]"]


def test_a_line_that_is_not_accepted_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SystemExit):
        configuration_of(["identify", "mydata/"])
    with pytest.raises(SystemExit):
        _accepted_by_study("studies.loop", ["--no-such-option"], monkeypatch)


def _accepted_by_study(name: str, options: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The study's own parsing, without the study."""
    module = importlib.import_module(IN_PACKAGES.get(name, name))
    parse: Callable[..., Any] = module.parse

    def parsed(*arguments: Any, **named: Any) -> None:
        parse(*arguments, **named)
        raise Parsed

    monkeypatch.setattr(module, "parse", parsed)
    with pytest.raises(Parsed):
        module.main(options)
