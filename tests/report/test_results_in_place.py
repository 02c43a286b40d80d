"""Results that cannot be moved to their place at once: a killed run, a busy file, a mount, a full disk."""

import errno
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from oed.report import result_folder
from tests.report.tried_folder import FILES, listing, run


class Full(Exception):
    """Stands for whatever ends a process."""


@pytest.mark.parametrize("moves", range(4))
def test_a_run_killed_while_it_moves_its_results_is_finished_by_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moves: int
) -> None:
    run(tmp_path, a="1", b="1")
    done = []

    def move(source: Path, target: Path) -> None:
        if len(done) == moves:
            raise Full
        done.append(target)
        target.parent.mkdir(exist_ok=True)
        source.replace(target)

    with monkeypatch.context() as patched:
        patched.setattr(result_folder, "_move", move)
        if moves < 2:
            with pytest.raises(Full):
                run(tmp_path, a="2", more_c="2")
        else:
            run(tmp_path, a="2", more_c="2")
    with FILES.in_folder(tmp_path):
        assert listing(tmp_path) == {"a.txt": "2", "more/c.txt": "2"}
    assert not (tmp_path / ".oed" / "new").exists()


def test_what_cannot_be_moved_is_named_and_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def busy(*_: object) -> None:
        raise OSError(errno.EBUSY, "Device or resource busy")

    with monkeypatch.context() as patched:
        patched.setattr(result_folder, "_move", busy)
        with pytest.raises(OSError, match=r"the results are whole in .*new"):
            run(tmp_path, a="1")
    run_nothing = FILES.in_folder(tmp_path)
    with run_nothing:
        assert listing(tmp_path) == {"a.txt": "1"}


@pytest.fixture
def mount(tmp_path: Path) -> Iterator[Path]:
    """A small file system of its own, as a container's volume is."""
    place = tmp_path / "mount"
    place.mkdir()
    command = shutil.which("mount")
    made = command and subprocess.run(
        [command, "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(place)],
        check=False,
        capture_output=True,
    )
    if not made or made.returncode:
        pytest.skip("this user may not mount a file system")
    yield place
    subprocess.run(["umount", str(place)], check=True)


def test_a_mount_is_a_folder_like_any_other(mount: Path) -> None:
    run(mount, a="1", b="1")
    run(mount, a="2", more_c="2")
    assert listing(mount) == {"a.txt": "2", "more/c.txt": "2"}


def test_a_full_disk_leaves_the_last_results(mount: Path) -> None:
    run(mount, a="1")
    with pytest.raises(OSError, match="No space left on device: what was there stays; make room"):
        run(mount, a="2", b="x" * 400_000)
    assert listing(mount) == {"a.txt": "1"}
    run(mount, a="3")
    assert listing(mount) == {"a.txt": "3"}


def test_a_mount_within_the_folder_takes_its_share(mount: Path) -> None:
    run(mount.parent, a="1")
    (mount.parent / "more").symlink_to(mount, target_is_directory=True)
    run(mount.parent, a="2", more_c="2")
    assert (mount / "c.txt").read_text() == "2"


def test_no_folder_is_ever_renamed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a mount's root and a lower layer of a container refuse, where none can be made here."""
    replace = Path.replace

    def files_only(path: Path, target: Path) -> Path:
        if path.is_dir() or not Path(target).is_relative_to(tmp_path / "out"):
            raise OSError(errno.EBUSY, "Device or resource busy")
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", files_only)
    run(tmp_path / "out", a="1", more_c="1")
    run(tmp_path / "out", a="2")
    assert listing(tmp_path / "out") == {"a.txt": "2"}
