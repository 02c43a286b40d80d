"""A folder for results holds the last run's: all of them, none of an earlier run, and the user's."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from oed.report.output_folder import check_output_folder
from oed.report.result_folder import ResultFiles
from oed.report.study_files import IDENTIFY
from tests.paths import REPO
from tests.report.tried_folder import FILES, fill, listing, run


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


@pytest.mark.parametrize("name", ["b.txt", "thesis.tex", ".bashrc", "sources/deep/main.c"])
@pytest.mark.parametrize("files", [FILES, ResultFiles("any")])
def test_a_folder_that_holds_anything_but_what_runs_left_is_refused(
    tmp_path: Path, name: str, files: ResultFiles, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / name).write_text("mine")
    monkeypatch.chdir(tmp_path)
    told = rf"holds {re.escape(name.partition('/')[0])}, and no run is recorded there"
    for folder in (tmp_path, Path()):
        with pytest.raises(ValueError, match=told), files.in_folder(folder):
            pass
    assert listing(tmp_path) == {name: "mine"}


def test_what_a_study_goes_on_from_is_no_other_s_file(tmp_path: Path) -> None:
    (tmp_path / "lines.csv").write_text("1")
    study = ResultFiles("study", ("summary.md",), goes_on=True)
    with study.in_folder(tmp_path):
        pass
    (tmp_path / "summary.md").write_text("mine")
    with pytest.raises(ValueError, match="holds summary"), study.in_folder(tmp_path):
        pass


def test_the_root_is_no_folder_for_results() -> None:
    with pytest.raises(ValueError, match="no run is recorded there"), FILES.in_folder(Path("/")):
        pass
    assert not Path("/.oed").exists()


def test_empty_folders_and_those_of_steps_are_nothing_to_lose(tmp_path: Path) -> None:
    run(tmp_path / "step", a="1")
    (tmp_path / "step" / "notes.txt").write_text("mine")
    (tmp_path / "lost+found").mkdir()
    (tmp_path / "more" / "empty").mkdir(parents=True)
    run(tmp_path, a="2")
    # From now on it is a folder for results, in which other files stay.
    (tmp_path / "notes.txt").write_text("mine")
    run(tmp_path, a="3")
    kept = {"a.txt": "3", "notes.txt": "mine", "step/a.txt": "1", "step/notes.txt": "mine"}
    assert {k: v for k, v in listing(tmp_path).items() if "/.oed/" not in k} == kept


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


def test_a_folder_that_cannot_be_held_keeps_what_it_knows(tmp_path: Path) -> None:
    """As on a file system without locks: the last run's record is what its results are known by."""
    out = tmp_path / "out"
    run(out, a="1")
    lock = out / ".oed" / "lock"
    lock.unlink(missing_ok=True)
    lock.mkdir()
    with pytest.raises(ValueError, match="cannot be written"):
        run(out, a="2")
    lock.rmdir()
    run(out, a="3")
    assert listing(out) == {"a.txt": "3"}


def test_who_works_there_is_called_as_it_was_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    monkeypatch.setattr(sys, "argv", ["/somewhere/oed/__main__.py", "identify", "data"])
    with FILES.in_folder(out), pytest.raises(ValueError, match="oed identify works there"):
        run(out, a="1")
