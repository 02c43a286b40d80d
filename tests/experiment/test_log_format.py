"""The keys that say how a log is written: columns, units, signs, rate, and cuts of one log."""

import dataclasses
import io
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oed.experiment.log_format import LogFormat
from oed.experiment.read_dataset import read_dataset
from oed.experiment.units import factor_to_si
from oed.robot.builtin import imi_scara
from tests.experiment.tiny_dataset import (
    MANIFEST,
    csv_text,
    refused,
    tiny_files,
    with_urdf,
    write_files,
)


def with_format(folder, lines: str, change) -> Path:
    """The tiny set with keys above its recordings, and its logs' tables changed alike."""
    files = tiny_files()
    files["dataset.toml"] = MANIFEST.replace("[[recording]]", f"{lines}\n[[recording]]", 1).encode()
    for name in ("estimation.csv", "test.csv"):
        frame = pd.read_csv(io.BytesIO(files[name]))
        files[name] = change(frame).to_csv(index=False).encode()
    return write_files(folder, files)


def agrees(folder, plain) -> bool:
    read = read_dataset(folder).test[0]
    return all(
        np.allclose(getattr(read, name), getattr(plain, name), rtol=1e-14, atol=1e-14)
        for name in ("t", "q", "tau")
    )


@pytest.fixture
def plain(tmp_path):
    return read_dataset(write_files(tmp_path / "plain", tiny_files())).test[0]


def test_columns_by_any_name(tmp_path, plain):
    lines = '[columns]\nt = "when"\nq = ["a", "b"]\ntau = ["c", "d"]'
    names = {"t": "when", "q_1": "a", "q_2": "b", "tau_1": "c", "tau_2": "d"}
    folder = with_format(tmp_path / "x", lines, lambda frame: frame.rename(columns=names))
    assert agrees(folder, plain)


def test_columns_in_another_order_than_the_joints(tmp_path, plain):
    lines = '[columns]\nt = "t"\nq = ["q_2", "q_1"]\ntau = ["tau_2", "tau_1"]'
    swapped = {"q_1": "q_2", "q_2": "q_1", "tau_1": "tau_2", "tau_2": "tau_1"}
    folder = with_format(tmp_path / "x", lines, lambda frame: frame.rename(columns=swapped))
    assert agrees(folder, plain)


def test_columns_by_number_where_there_is_no_header(tmp_path, plain):
    files = tiny_files()
    lines = "[columns]\nt = 1\nq = [2, 3]\ntau = [4, 5]\n[[recording]]"
    files["dataset.toml"] = MANIFEST.replace("[[recording]]", lines, 1).encode()
    for name in ("estimation.csv", "test.csv"):
        files[name] = files[name].partition(b"\n")[2]
    assert agrees(write_files(tmp_path / "x", files), plain)


def test_columns_named_by_joint(tmp_path, plain):
    names = {f"{q}_{j}": f"{q}_joint_{j}" for q in ("q", "tau") for j in (1, 2)}
    folder = with_format(tmp_path / "x", "", lambda frame: frame.rename(columns=names))
    assert agrees(folder, plain)


def test_a_fault_in_a_named_column_is_told_by_the_logs_own_name(tmp_path):
    lines = '[columns]\nt = "t"\nq = ["a", "q_2"]\ntau = ["tau_1", "tau_2"]'

    def change(frame):
        frame = frame.rename(columns={"q_1": "a"})
        frame["a"] *= 180 / np.pi * 4
        return frame

    error = refused(with_format(tmp_path, lines, change))
    assert error.column == "a"
    assert "degrees" in str(error)


def test_degrees_millinewtonmetres_milliseconds_signs_and_zeros(tmp_path, plain):
    lines = (
        'sign = [1, -1]\nzero = [10.0, -20.0]\n[units]\nt = "ms"\nq = "deg"\ntau = ["mN m", "N·cm"]'
    )

    def change(frame):
        frame = frame.copy()
        frame["t"] *= 1e3
        frame["q_1"] = np.rad2deg(frame["q_1"]) + 10.0
        frame["q_2"] = -np.rad2deg(frame["q_2"]) - 20.0
        frame["tau_1"] *= 1e3
        frame["tau_2"] *= -1e2
        return frame

    assert agrees(with_format(tmp_path / "x", lines, change), plain)


def test_ticks_and_a_sign_of_torque_alone(tmp_path, plain):
    lines = (
        'sign = {tau = [-1, 1]}\nzero = [2048, 2048]\n[units]\nq = "ticks"\nticks_per_turn = 4096'
    )

    def change(frame):
        frame = frame.copy()
        for column in ("q_1", "q_2"):
            frame[column] = frame[column] / (2 * np.pi) * 4096 + 2048
        frame["tau_1"] *= -1
        return frame

    assert agrees(with_format(tmp_path / "x", lines, change), plain)


def test_a_rate_where_no_column_tells_the_time(tmp_path, plain):
    folder = with_format(tmp_path / "x", "rate = 10", lambda frame: frame.drop(columns="t"))
    assert agrees(folder, plain)


def test_rows_that_repeat_the_one_before_exactly_are_left_out_with_a_note(tmp_path, plain):
    files = tiny_files()
    rows = files["test.csv"].splitlines(keepends=True)
    files["test.csv"] = b"".join([*rows[:5], rows[4], rows[4], *rows[5:]])
    read = read_dataset(write_files(tmp_path / "x", files)).test[0]
    assert np.array_equal(read.t, plain.t)
    assert "without 2 rows that repeat the row before exactly" in read.notes[0]
    assert "row 6" in read.notes[0]


def test_a_fault_below_rows_that_were_left_out_is_named_by_its_line(tmp_path):
    files = tiny_files()
    rows = files["test.csv"].splitlines(keepends=True)
    rows = [*rows[:5], rows[4], rows[4], *rows[5:]]
    rows[20] = rows[10]
    files["test.csv"] = b"".join(rows)
    error = refused(write_files(tmp_path, files))
    assert (error.row, error.column) == (21, "t")


CUT = """
[[recording]]
file = "all.csv"
name = "first"
role = "estimation"
{first}

[[recording]]
file = "all.csv"
name = "last"
role = "test"
{last}
"""


def cut_set(folder, first: str, last: str):
    head = MANIFEST.partition("[[recording]]")[0]
    files = {
        "dataset.toml": (head + CUT.format(first=first, last=last)).encode(),
        "all.csv": csv_text(0, rows=80).encode(),
    }
    return write_files(folder, files)


@pytest.mark.parametrize(
    ("first", "last"),
    [
        ("rows = [1, 40]", "rows = [41, 80]"),
        ("to = 3.95", "from = 3.95"),
        ("to = 4.0", "from = 4.0"),
    ],
)
def test_one_log_cut_into_recordings(tmp_path, first, last):
    table = np.loadtxt(csv_text(0, rows=80).splitlines(), delimiter=",", skiprows=1)
    dataset = read_dataset(cut_set(tmp_path, first, last))
    assert [r.name for r in dataset.recordings] == ["first", "last"]
    assert np.array_equal(dataset.estimation[0].q, table[:40, 1:3])
    assert np.array_equal(dataset.test[0].q, table[40:, 1:3])
    assert dataset.test[0].t[0] == table[40, 0]


@pytest.mark.parametrize(
    ("first", "last", "why"),
    [
        ("rows = [1, 40]", "rows = [40, 80]", "do not overlap"),
        ("to = 4.0", "from = 3.9", "do not overlap"),
        ("to = 4.0", "rows = [41, 80]", "do not overlap"),
        ("", "from = 4.0", "do not overlap"),
        ("rows = [1, 40]", "rows = [41, 81]", "the log has 80 rows"),
        ("to = 4.0", "from = 40.0", "no row from 40 s"),
        ("rows = [40, 1]", "rows = [41, 80]", "counted from 1"),
        ("rows = [1, 40]\nto = 3", "rows = [41, 80]", "by rows or by time"),
        ("from = 4.0\nto = 3.0", "rows = [41, 80]", "nothing"),
    ],
)
def test_cuts_that_cannot_be(tmp_path, first, last, why):
    assert why in str(refused(cut_set(tmp_path, first, last)))


@pytest.mark.parametrize(
    ("lines", "key", "why"),
    [
        ('[units]\nq = "furlong"', "units", "'furlong' is no unit of q"),
        ('[units]\nq = "mm"', "units", "of a revolute joint"),
        ('[units]\nq = ["deg"]', "units.q", "list of 2"),
        ('[units]\nq = "ticks"', "units", "ticks_per_turn"),
        ("sign = [1, 2]", "sign", "1 or -1"),
        ("sign = [1]", "sign", "1 values for 2 joints"),
        ("rate = 0", "rate", "positive"),
        ('rate = 10\n[columns]\nt = "t"', "rate", "leave one of them out"),
        ('[columns]\nq = ["q_1", "q_1"]', "columns.q", "twice"),
        (
            '[columns]\nq = ["q_1", "q_2"]\ntau = ["q_1", "q_2"]',
            "columns.tau",
            "named for q already",
        ),
        ('[columns]\nq = "q_1"\ntau = ["tau_1", "tau_2"]', "q_1", "must name 2 such"),
        ('[columns]\nspeed = ["q_1", "q_2"]', "columns.speed", "unknown key"),
    ],
)
def test_formats_that_cannot_be(tmp_path, lines, key, why):
    error = refused(with_format(tmp_path, lines, lambda frame: frame))
    assert error.column == key
    assert why in str(error)


def test_a_named_column_that_the_log_lacks_tells_the_nearest(tmp_path):
    lines = '[columns]\nt = "t"\nq = ["q_1", "q_2"]\ntau = ["tau1", "tau_2"]'
    error = refused(with_format(tmp_path, lines, lambda frame: frame))
    assert error.column == "tau1"
    assert "did you mean 'tau_1'" in str(error)


@pytest.mark.parametrize(
    ("quantity", "unit", "slides", "factor"),
    [
        ("dq", "rpm", False, 2 * np.pi / 60),
        ("dq", "deg/s", False, np.pi / 180),
        ("dq", "mm/s", True, 1e-3),
        ("ddq", "deg/s²", False, np.pi / 180),
        ("q", "mm", True, 1e-3),
        ("tau", "N mm", False, 1e-3),
        ("tau", "mA", False, 1e-3),
        ("tau", "kN", True, 1e3),
        ("t", "µs", False, 1e-6),
    ],
)
def test_factors_of_units(quantity, unit, slides, factor):
    assert factor_to_si(quantity, unit, slides=slides) == pytest.approx(factor, rel=1e-15)


def test_a_prismatic_joint_has_units_of_its_own():
    robot = imi_scara()
    first = dataclasses.replace(robot.joints[0], kind="prismatic")
    robot = dataclasses.replace(robot, joints=(first, robot.joints[1]))
    units = LogFormat(units={"q": ("mm", "deg"), "tau": ("N", "N m")})
    read = units.to_si("q", np.array([[250.0, 90.0]]), robot)
    assert np.allclose(read, [[0.25, np.pi / 2]], rtol=1e-15)
    with pytest.raises(ValueError, match="prismatic"):
        LogFormat(units={"q": ("deg",)}).check(robot)


def test_fixed_joints_stand_where_they_are_said_to(tmp_path):
    folder = with_urdf(tmp_path, 3)
    text = (folder / "dataset.toml").read_text()
    (folder / "dataset.toml").write_text(text.replace("[[rec", "[fixed]\njoint_3 = 0.5\n[[rec", 1))
    robot = read_dataset(folder).robot
    assert robot.held == {"joint_3": 0.5}
    (folder / "dataset.toml").write_text(text.replace("[[rec", "[fixed]\njoint_4 = 0.5\n[[rec", 1))
    assert refused(folder).column == "fixed"
