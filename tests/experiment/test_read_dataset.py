"""The reader refuses each fault that the format's page lists, and says where it is."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oed.errors import DataSetError
from oed.experiment.read_dataset import read_dataset
from tests.experiment.tiny_dataset import (
    MANIFEST,
    csv_text,
    spoil,
    tiny_files,
    urdf_text,
    with_line,
    write_files,
)
from tests.paths import SHARED_DATA, needs_shared_data


def refused(folder: Path, **chosen) -> DataSetError:
    """The error that reading the folder ends in; the folder must stay as it was."""
    before = sorted((path, path.stat().st_mtime_ns) for path in folder.rglob("*"))
    with pytest.raises(DataSetError) as caught:
        read_dataset(folder, **chosen)
    assert sorted((path, path.stat().st_mtime_ns) for path in folder.rglob("*")) == before
    error = caught.value
    assert error.file in str(error)
    assert error.row is None or f"row {error.row}" in str(error)
    assert error.column is None or error.column in str(error)
    return error


def with_urdf(folder: Path, joints: int) -> Path:
    files = tiny_files()
    files["dataset.toml"] = MANIFEST.replace("builtin:imi_scara", "robot.urdf").encode()
    files["robot.urdf"] = urdf_text(joints).encode()
    return write_files(folder, files)


def test_reads_what_is_there(tmp_path):
    dataset = read_dataset(write_files(tmp_path, tiny_files()))
    expected = np.loadtxt(tmp_path / "estimation.csv", delimiter=",", skiprows=1)
    (recording,) = dataset.estimation
    assert [r.name for r in dataset.test] == ["test"]
    assert dataset.validation == ()
    assert np.array_equal(recording.t, expected[:, 0])
    assert np.array_equal(recording.q, expected[:, 1:3])
    assert np.array_equal(recording.tau, expected[:, 3:])
    assert recording.dq is None
    assert recording.repetition is not None
    assert recording.repetition.tolist() == [k // 10 for k in range(30)]
    assert dataset.robot.joint_names == ("joint_1", "joint_2")


@pytest.mark.parametrize("ending", ["\r\n", "\r"])
def test_any_line_ending_and_a_byte_order_mark_read_the_same(tmp_path, ending):
    files = tiny_files()
    plain = read_dataset(write_files(tmp_path / "plain", files))
    text = files["estimation.csv"].decode().replace("\n", ending)
    files["estimation.csv"] = b"\xef\xbb\xbf" + text.encode()
    files["dataset.toml"] = b"\xef\xbb\xbf" + files["dataset.toml"].replace(b"\n", b"\r\n")
    other = read_dataset(write_files(tmp_path / "other", files))
    assert np.array_equal(other.estimation[0].q, plain.estimation[0].q)


def test_spaces_quotes_in_the_header_and_blank_lines_at_the_end_are_harmless(tmp_path):
    files = tiny_files()
    text = csv_text(0).replace("t,q_1,q_2", ' "t" , q_1,"q_2"').replace(",", ", ")
    files["estimation.csv"] = (text + "\n\n").encode()
    dataset = read_dataset(write_files(tmp_path, files))
    assert len(dataset.estimation[0]) == 30


def test_unknown_columns_are_reported(tmp_path):
    files = tiny_files()
    lines = csv_text(0).splitlines()
    lines = [lines[0] + ",note,current_9", *(line + ",ok," for line in lines[1:])]
    files["estimation.csv"] = ("\n".join(lines) + "\n").encode()
    dataset = read_dataset(write_files(tmp_path, files))
    assert dataset.estimation[0].unused_columns == ("note", "current_9")
    assert [column for _, column in dataset.unused] == ["note", "current_9"]


def test_currents_become_torques(tmp_path):
    plain = read_dataset(write_files(tmp_path / "plain", tiny_files()))
    folder = spoil(
        tmp_path / "drive",
        "dataset.toml",
        '[[recording]]\nfile = "est',
        '[drive]\ncurrent_to_torque = [2.0, -3.0]\ngear_ratio = [5, 6]\n[[recording]]\nfile = "est',
    )
    dataset = read_dataset(folder)
    assert np.array_equal(dataset.test[0].tau, plain.test[0].tau * [2.0, -3.0])
    assert dataset.drive.gear_ratio is not None
    assert dataset.drive.gear_ratio.tolist() == [5.0, 6.0]


def test_limits_of_the_data_set_override_those_of_the_robot(tmp_path):
    folder = spoil(
        tmp_path,
        "dataset.toml",
        '[[recording]]\nfile = "est',
        '[limits]\nposition = [[-2, 1], [-1, 3]]\nvelocity = [7, 6]\n[[recording]]\nfile = "est',
    )
    limits = read_dataset(folder).robot.limits
    assert limits.position.tolist() == [[-2, 1], [-1, 3]]
    assert limits.velocity.tolist() == [[-7, 7], [-6, 6]]
    assert limits.acceleration.tolist() == [[-5, 5], [-5, 5]]  # the robot's own


# What the format's page lists, in its order.


def test_missing_folder(tmp_path):
    assert "no such folder" in str(refused(tmp_path / "absent"))


@pytest.mark.parametrize("name", ["dataset.toml", "estimation.csv"])
def test_missing_file(tmp_path, name):
    folder = write_files(tmp_path, tiny_files())
    (folder / name).unlink()
    error = refused(folder)
    assert error.file.endswith(name)
    assert "missing" in str(error)


@pytest.mark.parametrize("robot", ["absent.urdf", ".", "builtin:nobody", "x\\u0000y"])
def test_missing_robot(tmp_path, robot):
    assert refused(spoil(tmp_path, "dataset.toml", "builtin:imi_scara", robot)).column == "robot"


@pytest.mark.parametrize(
    "line",
    [*MANIFEST.splitlines()[:8], 'file = "estimation.csv"', 'role = "test"'],
)
def test_missing_key(tmp_path, line):
    error = refused(spoil(tmp_path, "dataset.toml", line, ""))
    assert error.column is not None
    assert error.column.endswith(line.split(" =")[0])
    assert "missing" in str(error)


@pytest.mark.parametrize("column", ["t", "q_1", "q_2", "tau_1", "tau_2"])
def test_missing_column(tmp_path, column):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "estimation.csv")
    frame.rename(columns={column: f"x{column}"}).to_csv(tmp_path / "estimation.csv", index=False)
    error = refused(tmp_path)
    assert (error.column, error.row) == (column, 1)
    assert f"did you mean 'x{column}'" in str(error)


def test_velocity_of_one_joint_only(tmp_path):
    assert refused(spoil(tmp_path, "test.csv", "tau_1", "tau_1,dq_1")).column == "dq_2"


@pytest.mark.parametrize(
    "cell", ["abc", "", "nan", "NaN", "inf", "-inf", "1e999", "1e300", "1_0", "0x1", "1;5", "True"]
)
def test_cell_that_is_no_finite_number(tmp_path, cell):
    error = refused(with_line(tmp_path, 7, f"0.5,0.1,{cell},0.3,0.4"))
    assert (error.row, error.column) == (7, "q_2")


def test_row_with_too_few_or_too_many_cells(tmp_path):
    error = refused(with_line(tmp_path, 7, "0.5,0.1,0.2"))
    assert (error.row, error.column) == (7, "tau_1")
    assert refused(with_line(tmp_path, 7, "0.5,0.1,0.2,0.3,0,4")).row == 7
    assert refused(with_line(tmp_path, 7, "")).row == 7


def test_time_that_repeats(tmp_path):
    error = refused(with_line(tmp_path, 7, "0.4,0.1,0.2,0.3,0.4"))
    assert (error.row, error.column) == (7, "t")
    assert "repeats" in str(error)


def test_time_that_runs_back(tmp_path):
    error = refused(with_line(tmp_path, 7, "0.3,0.1,0.2,0.3,0.4"))
    assert (error.row, error.column) == (7, "t")
    assert "runs back" in str(error)


def test_joint_that_the_robot_lacks(tmp_path):
    folder = with_urdf(tmp_path, 2)
    text = (folder / "dataset.toml").read_text().replace("joint_2", "elbow")
    (folder / "dataset.toml").write_text(text)
    error = refused(folder)
    assert error.column == "joints"
    assert "elbow" in str(error)


def test_urdf_with_more_joints_than_the_manifest(tmp_path):
    error = refused(with_urdf(tmp_path, 3))
    assert error.column == "joints"
    assert "lists 2" in str(error)
    assert "has 3" in str(error)


def test_urdf_with_fewer_joints_than_the_manifest(tmp_path):
    assert refused(with_urdf(tmp_path, 1)).column == "joints"


def test_csv_with_more_joints_than_the_manifest(tmp_path):
    error = refused(spoil(tmp_path, "estimation.csv", "tau_2", "q_3"))
    assert (error.row, error.column) == (1, "q_3")
    assert "lists 2" in str(error)


def test_list_of_another_length_than_joints(tmp_path):
    error = refused(
        spoil(
            tmp_path,
            "dataset.toml",
            '[[recording]]\nfile = "est',
            '[limits]\nvelocity = [1]\n[[recording]]\nfile = "est',
        )
    )
    assert error.column == "limits.velocity"
    assert "1 values for 2 joints" in str(error)


def test_fewer_rows_than_parameters(tmp_path):
    files = tiny_files() | {"estimation.csv": csv_text(0, rows=23).encode()}
    assert "23 rows are fewer than the 24 parameters" in str(refused(write_files(tmp_path, files)))


@pytest.mark.parametrize("content", [b"", b"\n \n", b"\xef\xbb\xbf", b"t,q_1,q_2,tau_1,tau_2\n"])
def test_empty_file(tmp_path, content):
    error = refused(write_files(tmp_path, tiny_files() | {"test.csv": content}))
    assert error.file.endswith("test.csv")


def test_positions_in_degrees(tmp_path):
    folder = write_files(tmp_path, tiny_files())
    frame = pd.read_csv(folder / "test.csv")
    frame[["q_1", "q_2"]] *= 180 / np.pi
    frame.to_csv(folder / "test.csv", index=False)
    error = refused(folder)
    assert "degrees" in str(error)
    assert error.column == "q_1"
    assert error.row == frame["q_1"].abs().argmax() + 2


@pytest.mark.parametrize("cut", range(1, 40))
def test_truncated_last_line_wherever_it_ends(tmp_path, cut):
    """Even a cut inside the last number, which leaves a number, is seen."""
    files = tiny_files()
    whole = files["test.csv"]
    files["test.csv"] = whole[:-cut]
    cut_lines = files["test.csv"].count(b"\n")
    assert cut_lines == whole.count(b"\n") - 1
    error = refused(write_files(tmp_path, files))
    assert error.row == cut_lines + 1


@pytest.mark.parametrize(("old", "new"), [("period = 1.0", "period = 1.1"), ("= 3", "= 2")])
def test_repetitions_that_the_time_column_contradicts(tmp_path, old, new):
    error = refused(spoil(tmp_path, "dataset.toml", old, new))
    assert error.file.endswith("estimation.csv")
    assert error.column == "t"


def test_repetitions_that_the_repetition_column_contradicts(tmp_path):
    files = tiny_files()
    lines = csv_text(0).splitlines()
    lines = [lines[0] + ",repetition", *(f"{x},{i // 15}" for i, x in enumerate(lines[1:]))]
    files["estimation.csv"] = ("\n".join(lines) + "\n").encode()
    assert refused(write_files(tmp_path, files)).column == "repetition"


@pytest.mark.parametrize("cell", ["0.5", "-1"])
def test_repetition_that_is_no_index(tmp_path, cell):
    files = tiny_files()
    lines = csv_text(0).splitlines()
    lines = [lines[0] + ",repetition", *(f"{x},0" for x in lines[1:])]
    lines[4] = lines[4][:-1] + cell
    files["estimation.csv"] = ("\n".join(lines) + "\n").encode()
    error = refused(write_files(tmp_path, files))
    assert (error.row, error.column) == (5, "repetition")


# And what else a lab's files may hold.


@pytest.mark.parametrize(
    ("old", "new", "column"),
    [
        ("format = 1", "format = 2", "format"),
        ("format = 1", "format = true", "format"),
        ("format = 1", 'format = "1"', "format"),
        ('name = "tiny"', "name = 3", "name"),
        ('licence = "CC0"', 'license = "CC0"', "license"),
        ('["joint_1", "joint_2"]', '["joint_1", "joint_1"]', "joints"),
        ('["joint_1", "joint_2"]', '["joint_1", 2]', "joints"),
        ('["joint_1", "joint_2"]', "[]", "joints"),
        ("-9.81]", "-9.81, 0]", "gravity"),
        ("-9.81]", "nan]", "gravity"),
        ("-9.81]", "1e300]", "gravity"),
        ("-9.81]", "0x" + "f" * 5000 + "]", "gravity"),
        ('"measured"', '"mesured"', "torque"),
        ('role = "test"', 'role = "train"', "recording[2].role"),
        ('file = "test.csv"', 'file = "./estimation.csv"', "recording[2].file"),
        ('file = "test.csv"', 'file = "test.txt"', "recording[2].file"),
        ("repetitions = 3", "repetitions = 0", "recording[1].repetitions"),
        ("repetitions = 3", "repetitions = 3.0", "recording[1].repetitions"),
        ("period = 1.0", "period = -1.0", "recording[1].period"),
        ("period = 1.0", "periode = 1.0", "recording[1].periode"),
        ('torque = "measured"', 'torque = "measured"\nlimits = 3', "limits"),
    ],
)
def test_wrong_value_in_the_manifest(tmp_path, old, new, column):
    assert refused(spoil(tmp_path, "dataset.toml", old, new)).column == column


def test_unknown_key_names_the_nearest(tmp_path):
    error = refused(spoil(tmp_path, "dataset.toml", "licence", "license"))
    assert "did you mean 'licence'" in str(error)


@pytest.mark.parametrize(
    "limits",
    [
        "position = [[1, -1], [-1, 1]]",
        "velocity = [-1, 1]",
        "velocity = [nan, 1]",
        "position = [1, 1]",
        "speed = [1, 1]",
        "torque = [[1, 2, 3], 1]",
    ],
)
def test_wrong_limits(tmp_path, limits):
    old = '[[recording]]\nfile = "est'
    error = refused(spoil(tmp_path, "dataset.toml", old, f"[limits]\n{limits}\n{old}"))
    assert error.column == f"limits.{limits.split(' ')[0]}"


@pytest.mark.parametrize("text", ["a = = 1", "a = [" * 5000, "a = 1\na = 2", "a = " + "9" * 5000])
def test_manifest_that_is_no_toml(tmp_path, text):
    files = tiny_files() | {"dataset.toml": text.encode()}
    assert "TOML" in str(refused(write_files(tmp_path, files)))


def test_manifest_without_recordings(tmp_path):
    text = MANIFEST[: MANIFEST.index("[[rec")]
    files = tiny_files() | {"dataset.toml": text.encode()}
    assert refused(write_files(tmp_path, files)).column == "recording"


def test_the_same_file_by_two_paths(tmp_path):
    folder = spoil(tmp_path, "dataset.toml", 'file = "test.csv"', 'file = "link.csv"')
    (folder / "link.csv").symlink_to(folder / "estimation.csv")
    assert "same file" in str(refused(folder))


@pytest.mark.parametrize(
    ("separator", "name"), [(";", "semicolons"), ("\t", "tabs"), (" ", "spaces")]
)
def test_other_separators(tmp_path, separator, name):
    files = tiny_files()
    files["test.csv"] = files["test.csv"].replace(b",", separator.encode())
    error = refused(write_files(tmp_path, files))
    assert name in str(error)
    assert error.row == 1


def test_column_named_twice_or_not_at_all(tmp_path):
    assert refused(spoil(tmp_path / "a", "test.csv", "q_2", "q_1")).column == "q_1"
    assert "no name" in str(refused(spoil(tmp_path / "b", "test.csv", "q_2", "")))


def test_bytes_that_are_no_text(tmp_path):
    files = tiny_files()
    lines = files["test.csv"].split(b"\n")
    for byte in (b"\xff", b"\x00"):
        spoilt = b"\n".join([*lines[:3], byte + lines[3], *lines[4:]])
        assert refused(write_files(tmp_path, files | {"test.csv": spoilt})).row == 4


def test_a_robot_file_that_is_no_urdf(tmp_path):
    folder = with_urdf(tmp_path, 2)
    (folder / "robot.urdf").write_text("<robot")
    assert refused(folder).column == "robot"


# A subset of the joints.


def with_still_joint(folder: Path, position: float) -> Path:
    """Three joints, of which the second stands at `position` [rad]."""
    files = tiny_files()
    files["dataset.toml"] = (
        MANIFEST.replace("builtin:imi_scara", "robot.urdf")
        .replace('"joint_2"', '"joint_2", "joint_3"')
        .encode()
    )
    files["robot.urdf"] = urdf_text(3).encode()
    for name in ("estimation.csv", "test.csv"):
        frame = pd.DataFrame({"t": np.arange(40) * 0.075})
        for j, amplitude in enumerate((1.0, 0.0, 0.5)):
            frame[f"q_{j + 1}"] = amplitude * np.sin(2 * np.pi * frame["t"]) + (
                position if j == 1 else 0
            )
        frame[["tau_1", "tau_2", "tau_3"]] = np.arange(120.0).reshape(40, 3)
        write_files(folder, files)
        files[name] = frame.to_csv(index=False).encode()
    return write_files(folder, files)


def test_chosen_joints_come_in_the_order_chosen_and_the_others_are_locked(tmp_path):
    folder = with_still_joint(tmp_path, 0.5)
    dataset = read_dataset(folder, joints=["joint_3", "joint_1"])
    assert dataset.robot.joint_names == ("joint_3", "joint_1")
    assert dataset.robot.locked == ("joint_2",)
    assert dataset.estimation[0].tau[1].tolist() == [5.0, 3.0]
    # The third joint is carried by the first through a link bent by the locked angle.
    third = dataset.robot.joints[0]
    assert third.parent == 1
    elbow = np.array([0.3 + 0.3 * np.cos(0.5), 0.3 * np.sin(0.5), 0.0])
    assert np.allclose(third.p_PJ, elbow, rtol=0, atol=1e-12)


def test_a_joint_that_moves_cannot_be_left_out(tmp_path):
    error = refused(with_still_joint(tmp_path, 0.0), joints=["joint_1", "joint_2"])
    assert error.column == "q_3"
    assert "moves" in str(error)


@pytest.mark.parametrize("joints", [["nobody"], [], ["joint_1", "joint_1"]])
def test_joints_that_cannot_be_chosen(tmp_path, joints):
    assert refused(with_still_joint(tmp_path, 0.0), joints=joints).column == "joints"


# Parquet.


def as_parquet(folder: Path, frame: pd.DataFrame) -> Path:
    spoil(folder, "dataset.toml", "test.csv", "test.parquet")
    frame.to_parquet(folder / "test.parquet", index=False)
    return folder


@pytest.fixture
def frame(tmp_path):
    return pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")


def test_parquet_reads_as_csv(tmp_path, frame):
    from_csv = read_dataset(tmp_path)
    from_parquet = read_dataset(as_parquet(tmp_path, frame))
    assert np.array_equal(from_csv.test[0].q, from_parquet.test[0].q)
    assert np.array_equal(from_csv.test[0].tau, from_parquet.test[0].tau)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300, None])
def test_parquet_with_a_value_that_is_no_finite_number(tmp_path, frame, value):
    frame.loc[4, "tau_1"] = value
    error = refused(as_parquet(tmp_path, frame))
    assert (error.row, error.column) == (5, "tau_1")


def test_parquet_with_text_no_rows_or_a_missing_column(tmp_path, frame):
    assert refused(as_parquet(tmp_path, frame.astype({"q_1": str}))).column == "q_1"
    assert "no row" in str(refused(as_parquet(tmp_path, frame[:0])))
    assert refused(as_parquet(tmp_path, frame.drop(columns="q_2"))).column == "q_2"


def test_parquet_that_is_truncated(tmp_path, frame):
    folder = as_parquet(tmp_path, frame)
    content = (folder / "test.parquet").read_bytes()
    for keep in (3, 50, len(content) - 3):
        (folder / "test.parquet").write_bytes(content[:keep])
        assert refused(folder).file.endswith("test.parquet")


@needs_shared_data
@pytest.mark.parametrize(
    ("name", "joints", "rows"),
    [
        ("dfki_a0", 2, [21969, 1998, 1998, 1998, 1998]),
        ("staubli_tx40", 6, [22500, 7500, 15000]),
        ("franka_panda", 7, [8841, 7411, 2102, 2190]),
    ],
)
def test_reads_the_measured_sets(name, joints, rows):
    dataset = read_dataset(SHARED_DATA / name)
    assert dataset.robot.n == joints
    assert [len(recording) for recording in dataset.recordings] == rows
    assert dataset.unused == ()


def test_torque_that_was_not_logged(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "estimation.csv")
    frame["tau_2"] = 0.0
    frame.to_csv(tmp_path / "estimation.csv", index=False)
    error = refused(tmp_path)
    assert error.column == "tau_2"
    assert "was not logged" in str(error)


def test_an_arm_at_rest(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "estimation.csv")
    frame[["q_1", "q_2"]] = 1e-5 * np.random.default_rng(0).normal(size=(len(frame), 2))
    frame.to_csv(tmp_path / "estimation.csv", index=False)
    assert "an arm at rest" in str(refused(tmp_path))


# Columns that contradict one another.


def test_a_period_at_which_the_motion_does_not_repeat(tmp_path):
    files = tiny_files()
    text = files["dataset.toml"].decode().replace("repetitions = 3", "repetitions = 6")
    files["dataset.toml"] = text.replace("period = 1.0", "period = 0.5").encode()
    error = refused(write_files(tmp_path, files))
    assert error.column == "q_1"
    assert "does not repeat" in str(error)


def test_a_velocity_of_another_joint(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")
    for j in (1, 2):
        frame[f"q_{j}"] = np.sin(j * frame["t"])
        frame[f"dq_{j}"] = j * np.cos(j * frame["t"])
    frame.to_csv(tmp_path / "test.csv", index=False)
    assert read_dataset(tmp_path).test[0].dq is not None
    swapped = frame.rename(columns={"dq_1": "dq_2", "dq_2": "dq_1"})
    swapped.to_csv(tmp_path / "test.csv", index=False)
    assert "the columns are exchanged" in str(refused(tmp_path))


def test_time_in_milliseconds(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")
    frame["t"] *= 1000
    frame.to_csv(tmp_path / "test.csv", index=False)
    error = refused(tmp_path)
    assert error.column == "t"
    assert "milliseconds" in str(error)


def test_speeds_beyond_all_limits(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")
    frame["t"] /= 20
    frame.to_csv(tmp_path / "test.csv", index=False)
    assert "times its velocity limit" in str(refused(tmp_path))


def test_an_angle_that_is_folded_into_one_turn(tmp_path):
    folder = write_files(tmp_path, tiny_files())
    frame = pd.read_csv(folder / "test.csv")
    turning = np.pi - 0.5 + frame["t"]  # within the joint's range, once through pi
    frame["q_2"] = np.mod(turning + np.pi, 2 * np.pi) - np.pi
    frame.to_csv(folder / "test.csv", index=False)
    error = refused(folder)
    assert error.column == "q_2"
    assert error.row == int(np.argmax(turning >= np.pi)) + 2
    frame["q_2"] = turning
    frame.to_csv(folder / "test.csv", index=False)
    assert np.array_equal(read_dataset(folder).test[0].q[:, 1], turning)


@pytest.mark.parametrize(
    ("spoil_text", "row", "why"),
    [
        (lambda text: text.partition("\n")[2], 1, "add a header line"),
        (lambda text: "# by a logger\n" + text, 1, "comment stands where the header belongs"),
        (lambda text: text.replace("\n0,", '\n"0",'), 2, "without quotes"),
    ],
)
def test_first_lines_of_another_kind(tmp_path, spoil_text, row, why):
    files = tiny_files()
    files["test.csv"] = spoil_text(files["test.csv"].decode()).encode()
    error = refused(write_files(tmp_path, files))
    assert error.row == row
    assert why in str(error)


@pytest.mark.parametrize(
    ("old", "new", "key", "why"),
    [
        ('lower="-3" upper="3"', 'lower="3" upper="-3"', "robot", "lower limit 3 is above"),
        (
            '<joint name="joint_2" type="revolute">',
            '<joint name="joint_2" type="revolute"><mimic joint="joint_1"/>',
            "joints",
            "'joint_2' mimics 'joint_1'",
        ),
    ],
)
def test_a_robot_file_that_contradicts_itself_or_the_list_of_joints(tmp_path, old, new, key, why):
    folder = with_urdf(tmp_path, 2)
    text = (folder / "robot.urdf").read_text()
    (folder / "robot.urdf").write_text(text.replace(old, new, 1))
    error = refused(folder)
    assert error.column == key
    assert why in str(error)


def test_placeholder_inertias_do_not_stop_a_data_set(tmp_path):
    folder = with_urdf(tmp_path, 2)
    text = (folder / "robot.urdf").read_text()
    (folder / "robot.urdf").write_text(text.replace('mass value="1"', 'mass value="-1"'))
    assert len(read_dataset(folder).robot.inertia_faults) == 2
