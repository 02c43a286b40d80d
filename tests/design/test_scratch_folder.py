"""A temporary folder lives as long as its process and what it is for; a killed one's is cleared."""

import os
import signal
import subprocess
import sys
import tempfile

import pytest

from oed.design.scratch_folder import ScratchFolder

PREFIX = "oed-tried-"
MAKE = f"""
import sys, time
from oed.design.scratch_folder import ScratchFolder
made = ScratchFolder.new({PREFIX!r})
(made.path / "mesh.obj").write_text("v 0 0 0")
print(made.path, flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def _temporary(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)


@pytest.fixture
def other():
    with subprocess.Popen(
        [sys.executable, "-c", MAKE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        yield process
        process.kill()


def others(folder, own):
    return [x for x in folder.glob(f"{PREFIX}*") if x != own.path]


def test_the_folder_of_a_killed_process_is_removed_and_that_of_a_living_one_kept(other, tmp_path):
    made = ScratchFolder.new(PREFIX)
    (left,) = others(tmp_path, made)
    assert (left / "mesh.obj").exists()
    os.kill(other.pid, signal.SIGKILL)
    other.wait()
    again = ScratchFolder.new(PREFIX)
    assert not left.exists()
    assert made.path.exists()
    assert again.path.exists()


def test_what_is_not_provably_left_behind_is_kept(tmp_path):
    without_lock = tmp_path / f"{PREFIX}without"
    without_lock.mkdir()
    behind = tmp_path / "somewhere"
    behind.mkdir()
    (behind / "lock").touch()
    link = tmp_path / f"{PREFIX}link"
    link.symlink_to(behind)
    ScratchFolder.new(PREFIX)
    assert without_lock.exists()
    assert link.is_symlink()
    assert (behind / "lock").exists()


def test_a_folder_goes_with_the_last_who_refers_to_it():
    made = ScratchFolder.new(PREFIX)
    path = made.path
    assert path.is_dir()
    del made
    assert not path.exists()
