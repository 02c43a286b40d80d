"""A killed program leaves no process at work."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.paths import REPO

PATIENCE = 60.0  # [s]; what is tested takes milliseconds on a machine with nothing else to do


def until(holds, what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, what
        time.sleep(0.02)


def is_alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="no /proc to look for processes")
@pytest.mark.parametrize("how", ["pool", "forks"])
def test_workers_end_with_the_program_that_is_killed(tmp_path: Path, how: str) -> None:
    command = [sys.executable, "-m", "tests.studies.sleeper", how, str(tmp_path)]
    with subprocess.Popen(command, cwd=REPO, stderr=subprocess.DEVNULL) as program:
        try:
            until(lambda: len(list(tmp_path.glob("*.pid"))) == 2, "both cases begin")
            workers = [int(file.read_text()) for file in tmp_path.glob("*.pid")]
            assert all(map(is_alive, workers))
            assert {program.pid} != set(workers)
        finally:
            program.kill()
    try:
        until(lambda: not any(map(is_alive, workers)), f"{workers} are at work still")
    finally:
        for worker in filter(is_alive, workers):
            os.kill(worker, 9)
