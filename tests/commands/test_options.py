"""A frozen configuration is a command line."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import pytest

from oed import __version__
from oed.commands.configurations import Design, Diagnose, Feasible, Identify, ImportLog
from oed.commands.main import COMMANDS
from oed.commands.option_fields import options_of
from oed.commands.options import Count, Folder, Seed, parse
from oed.estimation.feasible.regularisation import Regularisation
from studies.study_options import CaseOptions
from tests.paths import REPO
from tests.running import oed


@dataclass(frozen=True)
class Nested:
    """How.

    Attributes:
        horizon: Length of the motion [s].
    """

    horizon: float = 10.0


@dataclass(frozen=True)
class Config:
    """Do something.

    Attributes:
        data: Where the data are.
        count: How many.
        seed: Of draws.
        joints: Names.
        how: Settings.
    """

    data: Folder
    count: Count = 3
    seed: Seed = 0
    joints: tuple[str, ...] = ()
    how: Nested = field(default_factory=Nested)

    def __post_init__(self) -> None:
        if "base" in self.joints:
            raise ValueError("--joints base: the base does not move")


@dataclass(frozen=True)
class Options(CaseOptions):
    """Which is better?"""

    study: ClassVar[str] = "which"


def told(arguments: list[str]) -> Config:
    return parse(Config, prog="oed something", arguments=arguments)


def test_options_fill_the_configuration_nested_ones_too(tmp_path: Path) -> None:
    line = ["--data", str(tmp_path), "--joints", "a", "b", "--horizon", "5", "--count", "1"]
    assert told(line) == Config(tmp_path, 1, 0, ("a", "b"), Nested(5.0))


def test_help_says_what_the_docstring_says(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        told(["--help"])
    text = capsys.readouterr().out
    assert all(t in text for t in ("oed something", "Do something.", "[s]", "(default: 3)"))


@pytest.mark.parametrize(
    ("option", "value", "reason"),
    [
        ("--count", "0", "0 is no whole number from 1 on"),
        ("--count", "2.5", "'2.5'"),
        ("--seed", "-1", "-1 is no whole number from 0 on"),
        ("--data", "nowhere", "nowhere: no such folder"),
        ("--joints", "base", "the base does not move"),
        ("--speed", "3", "Unrecognized options"),
    ],
)
def test_what_cannot_be_meant_ends_with_two_and_says_why(
    option: str, value: str, reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        told(["--data", str(tmp_path), option, value])
    assert reason in " ".join(capsys.readouterr().err.split())


NO_MODEL = "neither one of standard, offset, rotor nor a model.json that is there"


@pytest.mark.parametrize(
    ("command", "options", "line"),
    [
        (Feasible, "data --weight 0", "--weight 0 is no number from 1e-12 to 1e+06"),
        (Feasible, "data --weight 1e-300", "--weight 1e-300 is no number from 1e-12 to 1e+06"),
        (Feasible, "data --weight 1e7", "--weight 1e+07 is no number from 1e-12 to 1e+06"),
        (Design, "--robot a --margin 1e-300", "--margin 1e-300 is no number from 0.001 to 1"),
        (Design, "--robot a --scale nan", "--scale nan is no number from 0.001 to 1"),
        (Design, "--robot a --gravity 0 0 26", "--gravity 26 is no number from -25 to 25"),
        (
            ImportLog,
            "l --robot a --gravity 0 0 1e10",
            "--gravity 1e+10 is no number from -25 to 25",
        ),
        (Design, "--robot a --poses 1000000", "--poses 1000000 is no number from 1 to 100"),
        (Identify, "data --model Standard", f"--model Standard: {NO_MODEL}"),
        (Diagnose, "data --model stand", f"--model stand: {NO_MODEL}"),
        (Design, "--robot a --model Rotor", f"--model Rotor: {NO_MODEL}"),
        (
            Design,
            "--robot a --criterion j_d",
            "--criterion: 'j_d' is none of 'J_k', 'J_d', 'A', 'E'",
        ),
        (
            ImportLog,
            "log --robot a --ticks-per-turn 1e-300",
            "--ticks-per-turn 1e-300 is no number from 1 to 1e+10",
        ),
    ],
)
def test_what_nothing_can_be_made_of_is_refused_with_what_is_permitted(
    command: type, options: str, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        parse(command, prog="oed", arguments=[*options.split(), "--out", "x"])
    assert capsys.readouterr().err == f"oed: {line}; see oed --help\n"


@pytest.mark.parametrize("weight", [1e-12, 1e6])
def test_the_ends_of_a_range_are_within(weight: float) -> None:
    arguments = ["data", "--out", "x", "--weight", str(weight)]
    told = parse(Feasible, prog="oed", arguments=arguments).weight
    assert told == Regularisation(weight).weight


LONG = "/" + "/".join(c * 25 for c in "abcdef")


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--rate", "0"), "--rate 0 is no number from 1 to 1e+06"),
        (("--rat", "5"), "Unrecognized options: --rat, 5; perhaps you meant --rate"),
        (("--loaded", LONG), f"Unrecognized options: --loaded {LONG}; an option of oed payload, oed gains"),
        (("--rate", "1e308"), "--rate 1e+308 is no number from 1 to 1e+06"),
        (("--rate", "fast"), "--rate: 'fast' is no number"),
        (("--samples", "1e3"), "--samples: '1e3' is no whole number"),
        (("--seed", LONG), f"--seed: '{LONG}' is no whole number"),
    ],
)  # fmt: skip
def test_a_line_is_whole_and_short_whatever_the_terminal(
    encoding: str, options: tuple[str, str], line: str
) -> None:
    """Where a terminal has no lines to draw with, a frame is of hyphens."""
    done = subprocess.run(
        [sys.executable, "-m", "oed", "export", "model.json", "--to", "c", "--out", "x", *options],
        env={**os.environ, "PYTHONIOENCODING": encoding, "COLUMNS": "60"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == f"oed export: {line}; see oed export --help\n"


def test_a_try_does_not_replace_what_is_kept(tmp_path: Path) -> None:
    assert Options().results == Path("results/which")
    assert Options(smoke=True).results == Path("out/which")
    assert Options(smoke=True, out=tmp_path).results == tmp_path


def test_a_folder_that_cannot_be_written_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit, match="2"):
        parse(Options, prog="which", arguments=["--out", "/proc/oed"])
    assert "--out /proc/oed: cannot be written" in " ".join(capsys.readouterr().err.split())


def test_no_command_line_is_parsed_by_hand() -> None:
    """Every one is made from a configuration; only `oed` itself takes what it was given."""
    names = subprocess.run(
        ["git", "ls-files", "*.py"], cwd=REPO, capture_output=True, text=True, check=True
    )
    parsers = {"argparse", "optparse", "getopt", "click"}
    for name in names.stdout.split():
        text = (REPO / name).read_text(encoding="utf-8")
        if not any(word in text for word in (*parsers, "argv")):
            continue
        tree = ast.parse(text)
        imported = {
            alias.name
            for node in ast.walk(tree)
            if isinstance(node, (ast.Import, ast.ImportFrom))
            for alias in (*node.names, ast.alias(getattr(node, "module", "") or ""))
        }
        assert not parsers & imported, name
        given = [
            ast.unparse(node)
            for node in ast.walk(tree)
            if isinstance(node, ast.Subscript) and ast.unparse(node).startswith("sys.argv[")
        ]
        # The first is how the program was started.
        own = ("oed/commands/main.py", "oed/commands/options.py", "oed/report/folder_lock.py")
        assert name.startswith("tests/") or name in own or set(given) <= {"sys.argv[0]"}, name


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_a_default_only_where_there_is_one(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert oed(name, "--help") == 0
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert not re.findall(r"\(default: ?(?:None|False|''|)\)", text)
    options = options_of(COMMANDS[name][0])
    assert text.count("(default: ") == sum(not (o.is_required or o.is_left_out) for o in options)
    assert text.count("(required)") == sum(o.is_required for o in options)
    assert [o.name for o in options if not o.meaning] == []


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert oed("--version") == 0
    assert capsys.readouterr().out == f"oed {__version__}\n"


@pytest.mark.parametrize(
    "words", [["no-such-shell", "-"], ["tcsh", "-"], ["bash", "/no/such/file"]]
)
def test_a_shell_that_nothing_is_known_of_is_refused_in_one_line(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert oed("--tyro-write-completion", *words) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_gets_what_it_completes_by(
    shell: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert oed("--tyro-print-completion", shell) == 0
    script = capsys.readouterr().out
    assert [name for name in COMMANDS if name not in script] == []
    assert "--sign-width" in script
    if shell == "bash":
        (tmp_path / "oed").write_text(script)
        subprocess.run(["bash", "-n", "oed"], cwd=tmp_path, check=True)
