"""The commands of the readme run, one after another, on an arm and a log with the names they have there."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest

from oed.commands.main import configuration_of
from oed.robot import load_robot
from tests.docs.code_blocks import blocks
from tests.experiment.importing.laboratory_logs import bag_mcap, simulate, write_urdf
from tests.paths import REPO
from tests.running import oed

LINES = [
    shlex.split(line, comments=True)[1:]
    for block in blocks(REPO / "README.md", "bash")
    for line in block.splitlines()
    if line.startswith("oed ")
]
IMPORT = next(words for words in LINES if words[0] == "import")
# The demo, which has a test of its own, diagnoses too, and that takes longest. Gains are found from
# a log in amperes, and this one is in N m.
OTHERS = [words for words in LINES if words[0] not in ("import", "demo", "diagnose", "gains")]


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with arm.urdf and log.mcap, and what `oed import` makes of them."""
    folder = tmp_path_factory.mktemp("laboratory")
    robot = load_robot(write_urdf(folder / "arm.urdf"))
    bag_mcap(simulate(robot), folder).rename(folder / "log.mcap")
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert oed(*IMPORT) == 0
        assert oed(*(word.replace("mydata", "held") for word in IMPORT)) == 0
    finally:
        os.chdir(before)
    return folder


@pytest.mark.parametrize("words", OTHERS, ids=lambda words: words[0])
def test_runs(words: list[str], laboratory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(laboratory)
    config = configuration_of(words)
    less = ["--smoke"] if hasattr(config, "smoke") else []
    assert oed(*words, *less) == 0
    assert any(path.is_file() for path in Path(words[words.index("--out") + 1]).iterdir())
