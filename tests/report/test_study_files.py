"""A study's folder holds its last results: all of them, and none of an earlier run."""

from pathlib import Path

import pytest

from oed.report.json_file import write_json
from oed.report.study_files import CLOSE_LOOP, FEASIBLE, IDENTIFY


def fill(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).write_text(name)
    write_json(folder / "estimate.json", {"prediction": {}})


def half_written(out: Path) -> None:
    with IDENTIFY.replaced(out) as folder:
        (folder / "parameters.png").touch()
        raise KeyboardInterrupt


def test_only_what_the_last_run_wrote_is_left_and_what_is_not_the_study_s(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with IDENTIFY.replaced(out) as folder:
        fill(folder, "torque_validation.png", "report.html")
    (out / "notes.txt").write_text("mine")
    with IDENTIFY.replaced(out) as folder:
        fill(folder, "report.html")
    left = {path.name for path in out.iterdir()}
    assert left == {"estimate.json", "report.html", "notes.txt"}
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def test_an_interrupt_leaves_what_was_there(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        half_written(out)
    assert not list(tmp_path.iterdir())
    with IDENTIFY.replaced(out) as folder:
        fill(folder, "report.html")
    with pytest.raises(KeyboardInterrupt):
        half_written(out)
    assert {path.name for path in out.iterdir()} == {"estimate.json", "report.html"}


def test_no_empty_folder_stays_of_an_earlier_run(tmp_path: Path) -> None:
    out = tmp_path / "out"
    for motion in (True, False):
        with CLOSE_LOOP.replaced(out) as folder:
            (folder / "diagnosis.json").write_text('{"verdict": "ambiguous"}')
            if motion:
                (folder / "next_experiment").mkdir()
                (folder / "next_experiment" / "trajectory.csv").write_text("t,q_1\n")
    assert [path.name for path in out.iterdir()] == ["diagnosis.json"]


def test_another_study_s_results_are_not_replaced(tmp_path: Path) -> None:
    fill(tmp_path)
    IDENTIFY.check(tmp_path)
    for study in (FEASIBLE, CLOSE_LOOP):
        with pytest.raises(ValueError, match=r"holds results of studies\.identify"):
            study.check(tmp_path)
