from pathlib import Path

import numpy as np
import pytest

from oed.report.table import format_cell, markdown_table, read_csv, text_table, write_csv

ROWS = [
    {"robot": "ur5", "parameters": 36, "error": 1.5e-14, "agrees": True},
    {"robot": "panda | arm", "parameters": np.int64(43), "error": None},
]


def test_numbers_stand_right_and_text_left() -> None:
    lines = text_table(ROWS).splitlines()
    assert lines[0] == "robot        parameters      error  agrees"
    assert lines[2] == "ur5                  36  1.500e-14  yes"
    assert lines[3] == "panda | arm          43          –  –"


def test_markdown_escapes_the_bar_and_aligns_numbers() -> None:
    lines = markdown_table(ROWS, columns=["robot", "parameters"]).splitlines()
    assert lines == [
        "| robot | parameters |",
        "| --- | ---: |",
        "| ur5 | 36 |",
        r"| panda \| arm | 43 |",
    ]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.1, "0.1000"),
        (123456.0, "1.235e+05"),
        (1234.0, "1234"),
        (0.0, "0.000"),
        (np.float64(2.0), "2.000"),
        (float("nan"), "–"),
        (float("inf"), "infinite"),
        (np.float64("-inf"), "-infinite"),
        (False, "no"),
        (12, "12"),
    ],
)
def test_a_cell_reads_as_written_here(value, text: str) -> None:
    assert format_cell(value) == text


def test_csv_keeps_every_digit(tmp_path: Path) -> None:
    rows = [
        {"case": "a, b", "value": 0.1 + 0.2, "count": 3, "found": True, "note": None},
        {"case": 'say "c"', "value": 1e-300, "count": -1, "found": False, "note": "x\ny"},
    ]
    write_csv(tmp_path / "runs.csv", rows)
    assert read_csv(tmp_path / "runs.csv") == rows


def test_csv_fills_what_a_row_lacks(tmp_path: Path) -> None:
    write_csv(tmp_path / "runs.csv", ROWS)
    assert read_csv(tmp_path / "runs.csv")[1]["agrees"] is None


def test_csv_names_the_row_that_is_cut_short(tmp_path: Path) -> None:
    (tmp_path / "runs.csv").write_text("a,b\n1,2\n3\n", encoding="utf-8")
    with pytest.raises(ValueError, match="row 3"):
        read_csv(tmp_path / "runs.csv")


def test_refuses_to_write_nothing(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="neither rows nor columns"):
        write_csv(tmp_path / "runs.csv", [])
