"""A table of cases: one row a case, each of what would make it now, and nothing lost."""

import dataclasses
import os
import resource
import signal
import sys
from dataclasses import dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import pytest

from studies.case_runner import CaseRunner, Outcome, RowFile, all_failed, is_finished


@dataclass(frozen=True)
class Reading:
    """A file's length, which depends on its name as little as on where it lies."""

    file: Path
    factor: int = 1

    @property
    def key(self) -> tuple[str, ...]:
        return (self.file.name,)


def length(case: Reading) -> Outcome:
    text = case.file.read_text()
    if not text:
        raise ValueError("empty")
    return {"status": "done", "length": len(text) * case.factor}


def runner(folder: Path) -> CaseRunner[Reading]:
    rows = RowFile(folder / "runs.csv", ("file",), ("status", "length"))
    return CaseRunner(length, rows, "lengths", data=lambda case: case.file)


def readings(folder: Path, *texts: str) -> list[Reading]:
    found = [Reading(folder / f"{number}.txt") for number in range(len(texts))]
    for case, text in zip(found, texts, strict=True):
        case.file.write_text(text)
    return found


def test_other_data_of_the_same_name_are_done_anew_and_the_same_elsewhere_are_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    work = runner(tmp_path)
    cases = readings(tmp_path, "abc", "")
    assert work.run(cases) == 2
    assert work.rows.rows()[1]["status"] == "failed: ValueError: empty"
    cases[1].file.write_text("mended")
    assert work.run(cases) == 1
    assert "1 lines of other code or data are done again" in capsys.readouterr().err
    assert [row["length"] for row in work.rows.rows()] == ["3", "6"]
    (tmp_path / "elsewhere").mkdir()
    assert work.run(readings(tmp_path / "elsewhere", "abc", "mended")) == 0
    assert work.run([dataclasses.replace(case, factor=2) for case in cases]) == 2
    assert [row["length"] for row in work.rows.rows()] == ["6", "12"]


def test_other_code_does_the_work_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cases = readings(tmp_path, "abc")
    assert runner(tmp_path).run(cases) == 1
    monkeypatch.setattr("studies.case_runner.code_digest", lambda *_: "other")
    assert runner(tmp_path).run(cases) == 1
    assert runner(tmp_path).run(cases) == 0
    (line,) = runner(tmp_path).rows.path.read_text().splitlines()[1:]
    assert line == "0.txt,done,3," + runner(tmp_path).digest(cases[0])


def test_a_study_run_by_its_name_makes_the_lines_of_one_that_is_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (case,) = readings(tmp_path, "abc")
    imported = runner(tmp_path).digest(case)
    main = ModuleType("__main__")
    main.__spec__ = ModuleSpec(length.__module__, None)
    monkeypatch.setitem(sys.modules, "__main__", main)
    monkeypatch.setattr(length, "__module__", "__main__")
    assert runner(tmp_path).digest(case) == imported


def test_lines_of_before_there_were_digests_are_kept_in_view_and_done_anew(tmp_path: Path) -> None:
    (tmp_path / "runs.csv").write_text("file,status,length\n0.txt,done,7\nother.txt,done,9\n")
    work = runner(tmp_path)
    assert work.run(readings(tmp_path, "abc")) == 1
    assert [row["length"] for row in work.rows.rows()] == ["3", "9"]


def test_a_damaged_line_is_told_and_only_its_case_is_done_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    work = runner(tmp_path)
    cases = readings(tmp_path, "a", "ab", "abc", "abcd", "abcde")
    work.run(cases)
    lines = work.rows.path.read_bytes().splitlines(keepends=True)
    for number, damaged in ((2, b'1.txt,"done,2,\n'), (3, b"2.txt,\xff\xfe,3,x\n"), (4, b"\0\n")):
        lines[number] = damaged
    work.rows.path.write_bytes(b"".join(lines))
    assert work.run(cases) == 3
    told = capsys.readouterr().err
    assert [f"line {number}: cannot be read" in told for number in (2, 3, 4, 5, 6)] == [
        False,
        True,
        True,
        True,
        False,
    ]
    assert sorted(row["length"] for row in work.rows.rows()) == ["1", "2", "3", "4", "5"]


def test_rows_of_some_cases_stand_in_the_order_of_these(tmp_path: Path) -> None:
    rows = RowFile(tmp_path / "runs.csv", ("case",), ("status",))
    rows.prepare()
    for key in ("b", "c", "a"):  # as they happened to end
        rows.append((key,), {"status": "done"})
    assert [row["case"] for row in rows.rows_of([("a",), ("absent",), ("b",)])] == ["a", "b"]


def test_a_break_within_a_cell_breaks_no_line(tmp_path: Path) -> None:
    rows = RowFile(tmp_path / "runs.csv", ("case",), ("status",))
    rows.prepare()
    rows.append(("a",), {"status": 'one\ntwo "and", three'})
    assert rows.rows() == [{"case": "a", "status": 'one two "and", three'}]


def test_a_full_disk_cuts_no_line_and_says_what_is_kept(tmp_path: Path) -> None:
    rows = RowFile(tmp_path / "runs.csv", ("case",), ("status",))
    rows.prepare()
    rows.append(("a",), {"status": "done"})
    before = rows.path.read_bytes()
    # A file that may not grow is refused like one on a full disk: after a part is written.
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 10, limits[1]))
    try:
        with pytest.raises(OSError, match="what was done is kept"):
            rows.append(("b",), {"status": "x" * 100})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert rows.path.read_bytes() == before


def test_a_line_that_a_system_takes_in_parts_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = RowFile(tmp_path / "runs.csv", ("case",), ("status",))
    write = os.write
    monkeypatch.setattr(os, "write", lambda handle, text: write(handle, text[:3]))
    rows.prepare()
    rows.append(("a",), {"status": "done"})
    monkeypatch.undo()
    assert rows.rows() == [{"case": "a", "status": "done"}]


def test_a_table_in_which_all_failed_is_told_from_others(tmp_path: Path) -> None:
    work = runner(tmp_path)
    work.run(readings(tmp_path, "", ""))
    assert all_failed(work.rows.rows())
    work.run(readings(tmp_path, "", "a"))
    assert not all_failed(work.rows.rows())
    assert not all_failed([])


def test_a_study_of_other_data_is_not_finished(tmp_path: Path) -> None:
    work, cases = runner(tmp_path), readings(tmp_path, "abc")
    work.run(cases)
    (tmp_path / "provenance.json").write_text('{"configuration": {"size": 1}}')

    @dataclass(frozen=True)
    class Config:
        size: int = 1

    assert is_finished(work.rows, cases, Config(), work.digest)
    cases[0].file.write_text("other")
    assert not is_finished(work.rows, cases, Config(), work.digest)
