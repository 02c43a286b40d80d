"""A row an arm, whatever becomes of it, and a summary that says what the rows say."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from oed.report.table import Row, read_csv
from studies import design, design_arms
from studies.design_arms import Config, main, run, write
from tests.design.primitive_arm import planar_arm


def good(arm: str, **given) -> Row:
    return {
        "arm": arm, "wall_s": 3.1, "cpu_s": 2.2, "joints": 2, "base": 8, "feasible": True,
        "violation": -0.01, "J_k": 12.0, "J_d": 4.0, "J_d_continuous": 4.0,
        "d_efficiency": 0.5, "kind": "certified", "instants": 40, "horizon_s": 7.0,
        "evaluations": 9, "clear": "proven", "least_mm": 12.5,
        "J_k_not_clear": 11.0, "J_k_unsafe": 10.0, "J_d_not_clear": 5.0, "J_d_unsafe": 6.0,
        "least_mm_unsafe": -3.0, **given,
    }  # fmt: skip


def summary_of(rows: list[Row], out: Path) -> str:
    write(rows, Config(out=out, smoke=True))
    return (out / "summary.md").read_text()


def test_a_robot_gives_a_row_and_one_that_is_not_there_gives_its_problem(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    planar_arm(tmp_path)
    monkeypatch.chdir(tmp_path)  # robots and results are named from where the user stands
    truly = subprocess.run

    def here(command: list[str], **given) -> subprocess.CompletedProcess:
        # What works, in this process, which has all imported; what does not, as it is.
        if command[1:3] != ["-m", "studies.design"] or any("absent" in word for word in command):
            return truly(command, **given)
        return subprocess.CompletedProcess(command, design.main(command[3:]), "", "")

    monkeypatch.setattr(design_arms.subprocess, "run", here)
    assert main(["--robot", "planar.urdf", "absent.urdf", "--out", "res", "--smoke"]) == 0
    first, second = read_csv(tmp_path / "res" / "runs.csv")
    assert (first["arm"], first["joints"], first["feasible"]) == ("planar", 2, True)
    assert first["violation"] <= 0.0
    assert first["J_k"] >= 1.0
    assert first["wall_s"] > 0.0
    assert first["problem"] is None
    assert second["arm"] == "absent"
    assert "absent.urdf" in second["problem"]
    assert second["joints"] is None
    summary = (tmp_path / "res" / "summary.md").read_text()
    assert "1 of 2 arms" in summary
    assert (tmp_path / "res" / "provenance.json").is_file()


def test_a_run_that_takes_too_long_is_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    # Truly started and truly stopped: Python alone takes longer than a hundredth of a second.
    monkeypatch.setattr(design_arms, "LONGEST", 0.01)
    (row,) = run(Config(robots=("builtin:imi_scara",), smoke=True))
    assert row["problem"] == "not done after 0.01 s"
    assert "feasible" not in row


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("", "code -9"),
        ("Traceback\n  File x\nKeyError: 'a'\n", "Traceback File x KeyError: 'a'"),
        ("y" * 500, "y" * 200),
    ],
)
def test_a_run_that_dies_is_a_row_of_one_line(
    said: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(command: list[str], **_) -> subprocess.CompletedProcess:
        return subprocess.CompletedProcess(command, -9, "", said)

    monkeypatch.setattr(design_arms.subprocess, "run", killed)
    (row,) = run(Config(robots=("builtin:imi_scara",)))
    assert told in str(row["problem"])
    assert "\n" not in str(row["problem"])
    assert len(str(row["problem"])) <= 200


def test_the_summary_counts_what_is_proven_and_finite(tmp_path: Path) -> None:
    rows = [
        good("a"),
        good("b", wall_s=41.7, cpu_s=0.3),
        good("c", feasible=False, violation=0.2),
        good("d", J_k=None),
        {"arm": "e", "wall_s": 0.4, "cpu_s": 38.9, "problem": "no such robot file"},
    ]
    text = summary_of(rows, tmp_path)
    assert "2 of 5 arms" in text
    assert "41.7 s of wall" in text
    assert "38.9 s of CPU" in text
    assert "no such robot file" in text
    assert len(read_csv(tmp_path / "runs.csv")) == 5


def test_every_number_of_the_summarys_text_is_in_a_row(tmp_path: Path) -> None:
    rows = [good("a"), good("b", instants=60, wall_s=5.5)]
    text = summary_of(rows, tmp_path)
    prose, table = text.split("| arm", 1)
    assert "problem" not in table
    numbers = {float(number) for number in re.findall(r"(?<![\w.])\d+(?:\.\d+)?", prose)}
    counts = {2.0}
    held = {float(v) for row in rows for v in row.values() if isinstance(v, (int, float))}
    assert numbers <= held | counts
    assert {40.0, 60.0, 7.0, 5.5, 2.2} <= numbers


def test_the_summary_can_be_written_where_every_arm_failed(tmp_path: Path) -> None:
    rows: list[Row] = [{"arm": "e", "wall_s": 0.4, "cpu_s": 0.3, "problem": "no such robot file"}]
    assert "0 of 1 arms" in summary_of(rows, tmp_path)
    provenance = json.loads((tmp_path / "provenance.json").read_text())
    assert provenance["seed"] == 0
