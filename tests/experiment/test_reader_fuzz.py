"""Whatever a folder holds, the reader returns a data set or one `DataSetError`."""

import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from oed.errors import DataSetError
from oed.experiment.dataset import DataSet
from oed.experiment.read_dataset import read_dataset
from oed.experiment.write_dataset import write_columns
from tests.experiment.tiny_dataset import MANIFEST, tiny_files, urdf_text, write_files

FUZZ = settings(
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
FILES = ("dataset.toml", "estimation.csv", "test.csv")
CELLS = (
    "",
    " ",
    "nan",
    "inf",
    "-1e999",
    "1e308",
    "1e-320",
    "0x1p3",
    "1_0",
    "--1",
    "1.2.3",
    '"1"',
    "'",
    "1;2",
    "\t",
    "é",
    "\u2212" + "1",
    "0",
    "57.3",
    "1e9",
    "9" * 400,
    "#",
    "None",
)
VALUES = (
    "1",
    "-1",
    "true",
    '""',
    '"x"',
    "[]",
    "[[]]",
    "{}",
    "nan",
    "inf",
    "1979-05-27",
    "[1, 2]",
    "['joint_1']",
    "[[1, 2], [2, 1]]",
    "0x" + "f" * 5000,
    "1e400",
    "'\\u0000'",
    '"' + "x" * 9999 + '"',
    '"../"',
    "[nan, nan]",
    "{a = {b = 1}}",
    "'builtin:'",
    "'.csv'",
    "'dataset.toml'",
)
KEYS = (
    "format",
    "name",
    "source",
    "licence",
    "robot",
    "joints",
    "gravity",
    "torque",
    "file",
    "role",
    "repetitions",
    "period",
    "limits",
    "drive",
    "recording",
    "extra",
    "limits.position",
    "drive.current_to_torque",
    "drive.rotor_inertia",
)


@st.composite
def mutations(draw):
    """A function that spoils the content of one file."""
    kind = draw(st.sampled_from(("bytes", "cut", "line", "cell", "column", "value")))
    where = draw(st.floats(0, 1, exclude_max=True))
    if kind == "bytes":
        span, new = draw(st.integers(0, 8)), draw(st.binary(max_size=8))
        return lambda content: replaced(content, int(where * len(content)), span, new)
    if kind == "cut":
        return lambda content: content[: int(where * len(content))]
    if kind == "line":
        change = draw(st.sampled_from(("drop", "double", "swap", "blank")))
        return lambda content: with_line_changed(content, where, change)
    if kind == "column":
        change = draw(st.sampled_from(("drop", "double", "swap")))
        return lambda content: with_column_changed(content, where, change)
    if kind == "cell":
        cell, column = draw(st.sampled_from(CELLS)).encode(), draw(st.integers(0, 4))
        return lambda content: with_cell(content, where, column, cell)
    key, value = draw(st.sampled_from(KEYS)), draw(st.sampled_from(VALUES))
    return lambda content: with_value(content, where, f"{key} = {value}".encode())


def replaced(content: bytes, start: int, span: int, new: bytes) -> bytes:
    return content[:start] + new + content[start + span :]


def with_line_changed(content: bytes, where: float, change: str) -> bytes:
    lines = content.splitlines(keepends=True) or [b""]
    i = int(where * len(lines))
    line = lines[i]
    lines[i : i + 1] = {"drop": [], "double": [line, line], "blank": [b"\n"], "swap": [line]}[
        change
    ]
    if change == "swap":
        lines[i], lines[0] = lines[0], lines[i]
    return b"".join(lines)


def with_column_changed(content: bytes, where: float, change: str) -> bytes:
    rows = [line.split(b",") for line in content.splitlines()]
    i = int(where * 5)
    for row in rows:
        if len(row) > i:
            cell = row[i]
            row[i : i + 1] = {"drop": [], "double": [cell, cell], "swap": [cell]}[change]
            if change == "swap":
                row[i], row[0] = row[0], row[i]
    return b"".join(b",".join(row) + b"\n" for row in rows)


def with_cell(content: bytes, where: float, column: int, cell: bytes) -> bytes:
    lines = content.split(b"\n")
    i = int(where * len(lines))
    cells = lines[i].split(b",")
    cells[min(column, len(cells) - 1)] = cell
    lines[i] = b",".join(cells)
    return b"\n".join(lines)


def with_value(content: bytes, where: float, assignment: bytes) -> bytes:
    """A line `key = value` in place of the one with this key, or somewhere else."""
    lines = content.split(b"\n")
    key = assignment.split(b" =")[0]
    same = [i for i, line in enumerate(lines) if line.startswith(key + b" =")]
    i = same[0] if same else int(where * len(lines))
    lines[i : i + bool(same)] = [assignment]
    return b"\n".join(lines)


def read_or_refuse(folder: Path) -> str:
    """Read a folder and say how it ended; nothing in it may change, nothing else may be raised."""
    before = {path: path.read_bytes() for path in folder.rglob("*")}
    dataset, refusal = None, None
    try:
        dataset = read_dataset(folder)
    except DataSetError as error:
        refusal = error
    assert {path: path.read_bytes() for path in folder.rglob("*")} == before
    if refusal is not None:
        assert refusal.file
        assert str(refusal).startswith(refusal.file)
        return "refused"
    assert isinstance(dataset, DataSet)
    assert all(np.isfinite(recording.q).all() for recording in dataset.recordings)
    assert all((np.diff(recording.t) > 0).all() for recording in dataset.recordings)
    return "read"


def in_new_folder(files: dict[str, bytes]) -> str:
    parent = Path(tempfile.mkdtemp())
    try:
        outcome = read_or_refuse(write_files(parent / "set", files))
        assert [path.name for path in parent.iterdir()] == ["set"]
    finally:
        shutil.rmtree(parent)
    return outcome


def test_any_mutation_is_read_or_refused():
    outcomes = []

    @settings(FUZZ, max_examples=1000)
    @given(st.lists(st.tuples(st.sampled_from(FILES), mutations()), min_size=1, max_size=3))
    def fuzz(changes):
        files = tiny_files()
        for name, mutate in changes:
            files[name] = mutate(files[name])
        outcomes.append(in_new_folder(files))

    fuzz()
    # Both ways out were taken often, so that neither promise is empty.
    assert min(outcomes.count("read"), outcomes.count("refused")) > 40


@settings(FUZZ, max_examples=150)
@given(st.floats(0, 1, exclude_max=True), st.integers(0, 20), st.binary(max_size=20))
def test_any_robot_file_is_read_or_refused(where, span, new):
    urdf = urdf_text(2).encode()
    files = tiny_files() | {
        "dataset.toml": MANIFEST.replace("builtin:imi_scara", "robot.urdf").encode(),
        "robot.urdf": replaced(urdf, int(where * len(urdf)), span, new),
    }
    in_new_folder(files)


@pytest.fixture(scope="module")
def parquet(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("parquet") / "test.parquet"
    rng = np.random.default_rng(0)
    columns = {"t": np.arange(30) / 10}
    columns |= {name: rng.uniform(-1, 1, 30) for name in ("q_1", "q_2", "tau_1", "tau_2")}
    write_columns(path, columns)
    return path.read_bytes()


@settings(FUZZ, max_examples=150)
@given(where=st.floats(0, 1, exclude_max=True), span=st.integers(0, 20), new=st.binary(max_size=20))
def test_any_parquet_file_is_read_or_refused(parquet, where, span, new):
    files = tiny_files() | {
        "dataset.toml": MANIFEST.replace("test.csv", "test.parquet").encode(),
        "test.parquet": replaced(parquet, int(where * len(parquet)), span, new),
    }
    in_new_folder(files)
