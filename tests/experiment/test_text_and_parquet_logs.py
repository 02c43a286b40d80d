"""A recording's file, CSV or Parquet: what is harmless in it, and what is refused by row and column."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oed.experiment.read_dataset import read_dataset
from tests.experiment.tiny_dataset import (
    csv_text,
    refused,
    spoil,
    tiny_files,
    with_line,
    write_files,
)


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


@pytest.mark.parametrize(
    ("spoil_text", "row", "why"),
    [
        (lambda text: text.partition("\n")[2], 1, "add a header line"),
        (lambda text: text.replace("\n0,", '\n"0,'), 2, "a quote is not closed"),
        (lambda text: text.replace("\n0,", '\n"0"x,'), 2, "stands within a cell"),
    ],
)
def test_first_lines_of_another_kind(tmp_path, spoil_text, row, why):
    files = tiny_files()
    files["test.csv"] = spoil_text(files["test.csv"].decode()).encode()
    error = refused(write_files(tmp_path, files))
    assert error.row == row
    assert why in str(error)


def spelled(text: str, separator: str, *, comma: bool) -> bytes:
    """A table of commas and points, in another dialect."""
    text = text.replace(",", separator)
    return (text.replace(".", ",") if comma else text).encode()


@pytest.mark.parametrize(
    ("separator", "comma"), [(";", True), (";", False), ("\t", True), (" ", True), ("   ", False)]
)
@pytest.mark.parametrize("above", [b"", b"\xef\xbb\xbf", b"# by a logger\n", b"% one\n\n% two\n"])
def test_other_dialects_read_the_same(tmp_path, separator, comma, above):
    files = tiny_files()
    plain = read_dataset(write_files(tmp_path / "plain", files)).test[0]
    text = files["test.csv"].decode()
    other = above + spelled(text, separator, comma=comma)
    read = read_dataset(write_files(tmp_path / "other", files | {"test.csv": other})).test[0]
    assert np.array_equal(read.t, plain.t)
    assert np.array_equal(read.q, plain.q)
    assert np.array_equal(read.tau, plain.tau)


def test_a_spreadsheets_separator_line_and_quotes_are_harmless(tmp_path):
    files = tiny_files()
    plain = read_dataset(write_files(tmp_path / "plain", files)).test[0]
    rows = [line.split(",") for line in files["test.csv"].decode().splitlines()]
    quoted = "\r\n".join(";".join(f'"{cell}"'.replace(".", ",") for cell in row) for row in rows)
    other = b"sep=;\r\n" + quoted.encode() + b"\r\n"
    read = read_dataset(write_files(tmp_path / "other", files | {"test.csv": other})).test[0]
    assert np.array_equal(read.q, plain.q)


def test_a_fault_in_another_dialect_is_named_by_its_own_line(tmp_path):
    files = tiny_files()
    lines = files["test.csv"].decode().splitlines()
    lines[6] = lines[6].rpartition(",")[0] + ",x"
    text = "# by a logger\n\n" + "\n".join(lines) + "\n"
    files["test.csv"] = spelled(text, ";", comma=True)
    error = refused(write_files(tmp_path, files))
    assert (error.row, error.column) == (9, "tau_2")


def test_names_of_columns_in_the_last_comment_are_read(tmp_path):
    """As numpy.savetxt writes them."""
    files = tiny_files()
    plain = read_dataset(write_files(tmp_path / "plain", files)).test[0]
    files["test.csv"] = b"# run 3\n# " + files["test.csv"]
    read = read_dataset(write_files(tmp_path / "other", files)).test[0]
    assert np.array_equal(read.tau, plain.tau)


def test_bytes_that_are_no_text(tmp_path):
    files = tiny_files()
    lines = files["test.csv"].split(b"\n")
    for byte in (b"\xff", b"\x00"):
        spoilt = b"\n".join([*lines[:3], byte + lines[3], *lines[4:]])
        assert refused(write_files(tmp_path, files | {"test.csv": spoilt})).row == 4


@pytest.mark.parametrize("content", [b"", b"\n \n", b"\xef\xbb\xbf", b"t,q_1,q_2,tau_1,tau_2\n"])
def test_empty_file(tmp_path, content):
    error = refused(write_files(tmp_path, tiny_files() | {"test.csv": content}))
    assert error.file.endswith("test.csv")


def test_column_named_twice_or_not_at_all(tmp_path):
    folder = spoil(tmp_path / "a", "test.csv", "tau_1,tau_2", "tau_1,tau_2,q_1")
    text = (folder / "test.csv").read_text()
    (folder / "test.csv").write_text(text.replace("\n", ",0\n").replace("q_1,0\n", "q_1\n", 1))
    error = refused(folder)
    assert (error.row, error.column) == (1, "q_1")
    assert "two columns" in str(error)
    assert refused(spoil(tmp_path / "b", "test.csv", "q_2", "")).column == "q_2"


@pytest.mark.parametrize("column", ["t", "q_1", "q_2", "tau_1", "tau_2"])
def test_missing_column(tmp_path, column):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "estimation.csv")
    frame.rename(columns={column: f"x{column}"}).to_csv(tmp_path / "estimation.csv", index=False)
    error = refused(tmp_path)
    assert (error.column, error.row) == (column, 1)
    assert f"did you mean 'x{column}'" in str(error)


def test_velocity_of_one_joint_only(tmp_path):
    assert refused(spoil(tmp_path, "test.csv", "tau_2", "dq_1")).column in ("tau_2", "dq_2")


def test_csv_with_more_joints_than_the_manifest(tmp_path):
    error = refused(spoil(tmp_path, "estimation.csv", "tau_2", "q_3"))
    assert (error.row, error.column) == (1, "q_3")
    assert "lists 2" in str(error)


@pytest.mark.parametrize(
    "cell", ["abc", "inf", "-inf", "1e999", "1e300", "1_0", "0x1", "1;5", "True"]
)
def test_cell_that_is_no_finite_number(tmp_path, cell):
    error = refused(with_line(tmp_path, 7, f"0.5,0.1,{cell},0.3,0.4"))
    assert (error.row, error.column) == (7, "q_2")


def test_row_with_too_few_or_too_many_cells(tmp_path):
    error = refused(with_line(tmp_path, 7, "0.5,0.1,0.2"))
    assert (error.row, error.column) == (7, "tau_1")
    assert refused(with_line(tmp_path, 7, "0.5,0.1,0.2,0.3,0,4")).row == 7
    assert refused(with_line(tmp_path, 7, "")).row == 7


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


@pytest.mark.parametrize("value", [np.inf, 1e300])
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
