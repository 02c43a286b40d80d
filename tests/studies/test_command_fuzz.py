"""Spoilt inputs end in a documented way, whatever the command; see `command_fuzz`."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

from oed.commands.main import COMMANDS
from tests.paths import REPO
from tests.studies.spoiled_inputs import make_case

RUNS = 14


def test_spoilt_inputs_end_in_a_documented_way() -> None:
    """In a process without threads, from which each run is forked."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.studies.command_fuzz", "--runs", str(RUNS)],
        cwd=REPO,
        env={**os.environ, "OED_PROCESSES": "1", "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{RUNS} runs from 0: " in done.stdout


def test_a_case_follows_from_its_number(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in "ab"]
    for folder in folders:
        folder.mkdir()
    cases = [make_case(7, folder) for folder in folders]
    assert cases[0] == cases[1]
    contents = [{p.name: p.read_bytes() for p in folder.iterdir()} for folder in folders]
    assert contents[0] == contents[1]


def test_cases_reach_every_command_and_every_kind_of_file(tmp_path: Path) -> None:
    seen: Counter[str] = Counter()
    for number in range(400):
        folder = tmp_path / str(number)
        folder.mkdir()
        case = make_case(number, folder)
        seen[case.command] += 1
        seen.update(path.name for path in folder.iterdir())
    commands = set(COMMANDS)
    files = {"robot.urdf", "arm.xml", "arm.sdf", "dh.toml", "arm.urdf.xacro", "dataset.toml"}
    files |= {"model.json", "loaded", "bare"}
    assert commands | files <= set(seen)
