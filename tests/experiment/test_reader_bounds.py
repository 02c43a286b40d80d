"""A data set that would fill the memory, or never end, is one line at once."""

from __future__ import annotations

import os
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from oed import input_file
from oed.errors import LONGEST_MESSAGE
from oed.experiment.read_dataset import read_dataset
from oed.input_file import MOST_RECORDINGS
from tests.experiment.tiny_dataset import (
    MANIFEST,
    refused,
    spoil,
    tiny_files,
    urdf_text,
    with_urdf,
    write_files,
)


def named(folder: Path, log: str) -> Path:
    """The tiny data set whose estimation recording has another name."""
    return spoil(folder, "dataset.toml", "estimation.csv", log)


@pytest.mark.parametrize(
    "name", ["estimation.csv", "dataset.toml", "estimation.parquet", "estimation.h5"]
)
def test_a_pipe_is_no_file_of_a_data_set(tmp_path: Path, name: str) -> None:
    folder = (
        named(tmp_path, name) if name != "dataset.toml" else write_files(tmp_path, tiny_files())
    )
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)
    assert "is a pipe, not a file" in str(refused(folder))


@pytest.mark.parametrize("name", ["estimation.csv", "dataset.toml"])
def test_a_device_is_no_file_of_a_data_set(tmp_path: Path, name: str) -> None:
    folder = write_files(tmp_path, tiny_files())
    (folder / name).unlink()
    (folder / name).symlink_to("/dev/zero")
    assert "is a device, not a file" in str(refused(folder))


@pytest.mark.parametrize(
    ("name", "size"), [("estimation.csv", "2000 MB"), ("dataset.toml", "4 MB")]
)
def test_a_file_of_terabytes_is_not_read(tmp_path: Path, name: str, size: str) -> None:
    folder = write_files(tmp_path, tiny_files())
    with (folder / name).open("r+b") as file:
        file.truncate(3_000_000_000_000)
    assert f"is larger than {size} (3000000 MB)" in str(refused(folder))


def test_columns_without_an_end_are_one_line(tmp_path: Path) -> None:
    files = tiny_files()
    more = ",".join(f"x_{i}" for i in range(20_000))
    zeros = ",0" * 20_000
    lines = files["estimation.csv"].decode().splitlines()[:3]
    wide = [f"{lines[0]},{more}", *(line + zeros for line in lines[1:])]
    files["estimation.csv"] = ("\n".join(wide) + "\n").encode()
    error = refused(write_files(tmp_path, files))
    assert "holds 20005 columns, more than 10000" in str(error)


def test_five_thousand_recordings_are_one_line(tmp_path: Path) -> None:
    entry = '\n[[recording]]\nfile = "{}.csv"\nrole = "test"\n'
    files = tiny_files()
    files["dataset.toml"] += "".join(entry.format(i) for i in range(4998)).encode()
    error = refused(write_files(tmp_path, files))
    assert f"lists 5000 recordings, more than {MOST_RECORDINGS}" in str(error)


def test_names_without_an_end_are_one_line(tmp_path: Path) -> None:
    names = ", ".join(f'"j{i}"' for i in range(100_000))
    folder = spoil(tmp_path, "dataset.toml", '["joint_1", "joint_2"]', f"[{names}]")
    error = refused(folder)
    assert len(str(error)) < LONGEST_MESSAGE + 100


def test_columns_that_take_no_room_in_a_file_are_not_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(input_file, "MOST_NUMBERS", 400_000)
    folder = named(tmp_path, "estimation.parquet")
    names = ("t", "q_1", "q_2", "tau_1", "tau_2")
    table = pa.table({name: np.zeros(100_000) for name in names})
    pq.write_table(table, folder / "estimation.parquet")
    assert (folder / "estimation.parquet").stat().st_size < 10_000
    assert "holds 500000 numbers" in str(refused(folder))


def test_a_sparse_array_is_not_unpacked(tmp_path: Path) -> None:
    folder = named(tmp_path, "estimation.h5")
    with h5py.File(folder / "estimation.h5", "w") as file:
        file.create_dataset("t", shape=(10**12,), dtype="f8", chunks=(1000,))
    assert "holds 1000000000000 numbers" in str(refused(folder))


def test_a_packed_archive_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(input_file, "MOST_NUMBERS", 400_000)
    folder = named(tmp_path, "estimation.npz")
    np.savez_compressed(folder / "estimation.npz", t=np.zeros(500_000))
    assert (folder / "estimation.npz").stat().st_size < 10_000
    assert "holds 500016 numbers" in str(refused(folder))  # and the header


def with_gripper(folder: Path, fixed: str = "") -> Path:
    """The data set on a chain of four joints, of which the fourth mimics the third."""
    with_urdf(folder, 4)
    head = '<joint name="joint_4" type="revolute">'
    mimic = '<mimic joint="joint_3" multiplier="2" offset="0.1"/>'
    (folder / "robot.urdf").write_text(urdf_text(4).replace(head, head + mimic))
    text = MANIFEST.replace("builtin:imi_scara", "robot.urdf")
    (folder / "dataset.toml").write_text(text.replace("[[rec", f"{fixed}\n[[rec", 1))
    return folder


def test_a_joint_that_mimics_another_needs_no_mention(tmp_path: Path) -> None:
    folder = with_gripper(tmp_path, "[fixed]\njoint_3 = 0.2")
    assert read_dataset(folder).robot.held == {"joint_3": 0.2, "joint_4": pytest.approx(0.5)}
    error = refused(with_gripper(tmp_path))
    assert "not listed: joint_3. Record these too, or say in [fixed]" in str(error)


def test_an_angle_in_degrees_is_no_place_to_be_fixed_at(tmp_path: Path) -> None:
    error = refused(with_gripper(tmp_path, "[fixed]\njoint_3 = 90.0"))
    assert error.column == "fixed"
    assert "cannot hold 'joint_3' at 90: its range is -3 to 3 rad or m" in str(error)


def test_what_was_replaced_in_the_robot_is_a_note_of_the_data_set(tmp_path: Path) -> None:
    folder = with_urdf(tmp_path, 2)
    text = urdf_text(2).replace('ixx="1"', 'ixx="-1"', 1)
    (folder / "robot.urdf").write_text(text)
    assert "link 'link_1': no body has principal moments" in read_dataset(folder).notes[0]


def test_a_table_of_denavit_hartenberg_parameters_is_a_robot(tmp_path: Path) -> None:
    folder = with_urdf(tmp_path, 2)
    row = "[[joint]]\na = 0.3\nalpha = 0.0\nlower = -3.0\nupper = 3.0\n"
    (folder / "dh.toml").write_text(f'convention = "modified"\n{row}{row}')
    (folder / "dataset.toml").write_text(MANIFEST.replace("builtin:imi_scara", "dh.toml"))
    robot = read_dataset(folder).robot
    assert robot.joint_names == ("joint_1", "joint_2")
    assert robot.joints[1].p_PJ == pytest.approx([0.3, 0, 0])
