"""A folder for results holds the last run's: all of them, none of an earlier run, and the user's."""

import errno
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from oed.report import result_folder
from oed.report.output_folder import check_output_folder
from oed.report.result_folder import ResultFiles
from oed.report.study_files import CLOSE_LOOP, DESIGN, FEASIBLE, IDENTIFY
from tests.paths import REPO

FILES = ResultFiles("try", ("a.txt", "b.txt", "more/c.txt"))


def run(out: Path, **texts: str) -> None:
    with FILES.in_folder(out) as results, results.replaced() as new:
        fill(new, **texts)


def fill(folder: Path, **texts: str) -> None:
    for name, text in texts.items():
        path = folder / f"{name.replace('_', '/')}.txt"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)


def listing(folder: Path) -> dict[str, str]:
    """Content of all files that a user put there or reads."""
    files = (path for path in folder.rglob("*") if path.is_file())
    told = {path.relative_to(folder).as_posix(): path.read_text() for path in files}
    return {name: text for name, text in told.items() if not name.startswith(".oed/")}


def half_written(out: Path) -> None:
    with FILES.in_folder(out) as results, results.replaced() as new:
        fill(new, a="half")
        raise KeyboardInterrupt


def test_only_what_the_last_run_wrote_is_left_and_what_is_the_user_s(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    run(out, a="1", more_c="1")
    (out / "notes.txt").write_text("mine")
    run(out, a="2", b="2")
    assert listing(out) == {"a.txt": "2", "b.txt": "2", "notes.txt": "mine"}
    assert not (out / "more").exists()
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def test_an_interrupt_leaves_what_was_there(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with pytest.raises(KeyboardInterrupt):
        half_written(out)
    assert not list(tmp_path.iterdir())
    run(out, a="1")
    with pytest.raises(KeyboardInterrupt):
        half_written(out)
    assert listing(out) == {"a.txt": "1"}
    assert not (out / ".oed" / "new").exists()


def test_what_the_user_changed_or_put_there_stays_and_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(tmp_path, a="1", b="1")
    (tmp_path / "a.txt").write_text("mine")
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "c.txt").write_text("mine too")
    run(tmp_path, a="2", more_c="2")
    told = capsys.readouterr().err
    assert "a.txt was changed since a run left it" in told
    assert f"{tmp_path / 'more/c.txt'} is no run's: it stays; new is more/c.new.txt" in told
    kept = {"a.txt": "mine", "more/c.txt": "mine too"}
    assert listing(tmp_path) == {**kept, "a.new.txt": "2", "more/c.new.txt": "2"}
    # The new ones are a run's, and give way to the next run's.
    run(tmp_path, a="3")
    assert listing(tmp_path) == {**kept, "a.new.txt": "3"}
    (tmp_path / "a.txt").unlink()
    run(tmp_path, a="4")
    assert listing(tmp_path) == {"a.txt": "4", "more/c.txt": "mine too"}


def test_a_changed_file_that_the_next_run_would_not_write_stays_too(tmp_path: Path) -> None:
    run(tmp_path, a="1", b="1")
    (tmp_path / "b.txt").write_text("mine")
    run(tmp_path, a="2")
    assert listing(tmp_path) == {"a.txt": "2", "b.txt": "mine"}


def test_a_folder_with_files_of_these_names_and_no_record_is_refused(tmp_path: Path) -> None:
    (tmp_path / "b.txt").write_text("mine")
    with pytest.raises(ValueError, match=r"b\.txt in it would be lost"):
        run(tmp_path, a="1")
    assert listing(tmp_path) == {"b.txt": "mine"}
    # Whose names are not known beforehand, goes to an empty folder or to its own.
    with (
        pytest.raises(ValueError, match="no run is recorded"),
        ResultFiles("any").in_folder(tmp_path),
    ):
        pass


def test_a_record_that_names_what_lies_elsewhere_is_none(tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(out, a="1")
    (tmp_path / "mine.txt").write_text("1")
    record = json.loads((out / ".oed" / "record.json").read_text())
    record["files"]["../mine.txt"] = record["files"]["a.txt"]
    (out / ".oed" / "record.json").write_text(json.dumps(record))
    with pytest.raises(ValueError, match="no run is recorded"):
        run(out, b="2")
    assert listing(tmp_path)["mine.txt"] == "1"


def test_another_command_s_results_are_not_replaced(tmp_path: Path) -> None:
    run(tmp_path, a="1")
    with pytest.raises(ValueError, match="holds results of try"), IDENTIFY.in_folder(tmp_path):
        pass
    assert listing(tmp_path) == {"a.txt": "1"}


def data_set(folder: Path) -> Path:
    """Files of a data set as far as their names go."""
    for name in ("recordings", "urdf", "meshes"):
        (folder / name).mkdir(parents=True)
    (folder / "dataset.toml").write_text(
        f'robot = "urdf/arm.urdf"\nsource = "{"x" * 300}"\n[[recording]]\nfile = "recordings/a.csv"\n'
    )
    (folder / "recordings" / "a.csv").write_text("t,q_1,tau_1\n")
    (folder / "urdf" / "arm.urdf").write_text('<mesh filename="../meshes/link.stl"/>')
    (folder / "meshes" / "link.stl").write_text("solid")
    return folder


@pytest.mark.parametrize("command", [IDENTIFY, FEASIBLE, CLOSE_LOOP, DESIGN])
@pytest.mark.parametrize("inside", ["", "recordings", "urdf", "meshes", "other/../recordings"])
def test_no_results_go_where_inputs_lie(tmp_path: Path, command: ResultFiles, inside: str) -> None:
    data = data_set(tmp_path / "data")
    (data / "other").mkdir()
    before = listing(data)
    with pytest.raises(ValueError, match="choose another folder"):  # noqa: SIM117
        with command.in_folder(data / inside, [data]):
            pass
    assert listing(data) == before
    assert not list(data.rglob(".oed"))


def test_a_link_or_a_robot_s_file_or_its_package_leads_to_the_same_refusal(tmp_path: Path) -> None:
    data = data_set(tmp_path / "data")
    (tmp_path / "link").symlink_to(data, target_is_directory=True)
    arm = tmp_path / "arm.urdf"
    arm.write_text('<mesh filename="package://arm/meshes/link.stl"/>')
    for out, given in (("link", data), ("data/urdf", data / "urdf" / "arm.urdf"), (".", arm)):
        with pytest.raises(ValueError, match="choose another"):  # noqa: SIM117
            with DESIGN.in_folder(tmp_path / out, [given]):
                pass
    with (
        pytest.raises(ValueError, match=r"holds link\.stl"),
        DESIGN.in_folder(data / "meshes", [arm]),
    ):
        pass


def test_a_data_set_that_is_not_read_is_no_place_for_results_either(tmp_path: Path) -> None:
    data = data_set(tmp_path / "data")
    with pytest.raises(ValueError, match="is a data set"), DESIGN.in_folder(data, ["builtin:x"]):
        pass


def test_a_folder_of_its_own_within_the_data_s_is_fine(tmp_path: Path) -> None:
    data = data_set(tmp_path / "data")
    for _ in range(2):
        with FILES.in_folder(data / "results", [data]) as results, results.replaced() as new:
            fill(new, a="1")
    assert listing(data / "results") == {"a.txt": "1"}


def test_no_result_has_a_name_that_a_data_set_has_for_its_own() -> None:
    roles = ("estimation", "validation", "test")
    taken = {"dataset.toml", *(f"{n}.{s}" for n in roles for s in ("csv", "parquet", "toml"))}
    taken |= {f"robot.{s}" for s in ("urdf", "sdf", "xml", "xacro")}
    for command in (IDENTIFY, FEASIBLE, CLOSE_LOOP, DESIGN):
        assert not taken & set(command.names)


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


HOLD = """
import sys, time
from pathlib import Path
from oed.report.result_folder import ResultFiles
with ResultFiles("try", ("a.txt",)).in_folder(Path(sys.argv[1])) as results:
    with results.replaced() as new:
        (new / "a.txt").write_text("half")
        print("held", flush=True)
        time.sleep(60)
"""


def test_a_second_run_is_told_who_works_there_and_a_killed_one_blocks_nobody(
    tmp_path: Path,
) -> None:
    out = tmp_path / "out"
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(out)], stdout=subprocess.PIPE, text=True, cwd=REPO
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(ValueError, match=rf"process {other.pid} on .* since .*: wait for it"):
            run(out, a="1")
        other.kill()
    assert (out / ".oed" / "new" / "a.txt").exists()
    run(out, a="2")
    assert listing(out) == {"a.txt": "2"}
    assert not (out / ".oed" / "new").exists()
    assert json.loads((out / ".oed" / "record.json").read_text())["command"] == "try"


def test_a_run_that_leaves_nothing_leaves_no_folder(tmp_path: Path) -> None:
    with FILES.in_folder(tmp_path / "a" / "b"):
        assert (tmp_path / "a" / "b" / ".oed").is_dir()
    assert not list(tmp_path.iterdir())
    check_output_folder(tmp_path / "a" / "b")
