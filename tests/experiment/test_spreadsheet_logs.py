"""What spreadsheets and loggers write about a table: UTF-16, units beside names, clock times."""

import io
import tomllib

import numpy as np
import pandas as pd
import pytest

from oed.errors import DataSetError
from oed.experiment.logs import read_log
from oed.experiment.read_dataset import read_dataset
from tests.experiment.tiny_dataset import MANIFEST, refused, tiny_files, write_files
from tests.running import oed


@pytest.fixture
def plain(tmp_path):
    return read_dataset(write_files(tmp_path / "plain", tiny_files())).test[0]


def in_degrees(spelling: str) -> bytes:
    """The test recording in degrees and milliseconds, which its names say."""
    frame = pd.read_csv(io.BytesIO(tiny_files()["test.csv"]))
    named = {spelling.format("t", "ms"): frame["t"] * 1e3}
    for j in (1, 2):
        named[spelling.format(f"q_{j}", "deg")] = np.rad2deg(frame[f"q_{j}"])
        named[spelling.format(f"tau_{j}", "mN m")] = frame[f"tau_{j}"] * 1e3
    return pd.DataFrame(named).to_csv(index=False).encode()


def agrees(read, plain) -> bool:
    return all(
        np.allclose(getattr(read, name), getattr(plain, name), rtol=1e-12, atol=1e-12)
        for name in ("t", "q", "tau")
    )


@pytest.mark.parametrize("spelling", ["{} [{}]", "{}[{}]", "{} ({})", "{} / {}"])
def test_a_unit_beside_a_name_holds(tmp_path, plain, spelling):
    files = tiny_files() | {"test.csv": in_degrees(spelling)}
    assert agrees(read_dataset(write_files(tmp_path / "x", files)).test[0], plain)


def test_a_unit_in_the_manifest_goes_before_that_beside_a_name(tmp_path, plain):
    text = in_degrees("{} [{}]").replace(b"[deg]", b"[rad]")
    stated = MANIFEST.replace("[[recording]]", '[units]\nq = "deg"\n[[recording]]', 1)
    other = tiny_files()["estimation.csv"]
    degrees = pd.read_csv(io.BytesIO(other))
    degrees[["q_1", "q_2"]] = np.rad2deg(degrees[["q_1", "q_2"]])
    files = {
        "dataset.toml": stated.encode(),
        "estimation.csv": degrees.to_csv(index=False).encode(),
        "test.csv": text,
    }
    assert agrees(read_dataset(write_files(tmp_path / "x", files)).test[0], plain)


def test_a_line_of_units_below_the_names_holds(tmp_path, plain):
    header, _, rows = in_degrees("{}|{}").decode().partition("\n")
    pairs = [cell.split("|") for cell in header.split(",")]
    names, units = (",".join(part) for part in zip(*pairs, strict=True))
    files = tiny_files() | {"test.csv": f"{names}\n{units}\n{rows}".encode()}
    assert agrees(read_dataset(write_files(tmp_path / "x", files)).test[0], plain)
    spoilt = rows.splitlines()
    spoilt[4] = "x" + spoilt[4]
    files["test.csv"] = "\n".join([names, units, *spoilt, ""]).encode()
    error = refused(write_files(tmp_path / "y", files))
    assert (error.row, error.column) == (7, "t [ms]")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-16-le"])
def test_utf_16_reads_as_utf_8(tmp_path, plain, encoding):
    text = tiny_files()["test.csv"].decode().replace(",", "\t").replace(".", ",")
    if encoding != "utf-16":  # which writes its mark itself
        text = "\ufeff" + text
    content = text.replace("\n", "\r\n").encode(encoding)
    files = tiny_files() | {"test.csv": content}
    assert agrees(read_dataset(write_files(tmp_path / "x", files)).test[0], plain)
    files["test.csv"] = content[:-1]
    assert "UTF-16" in str(refused(write_files(tmp_path / "y", files)))


def test_windows_1252_reads_as_utf_8(tmp_path, plain):
    text = in_degrees("{} [{}]").decode().replace("[deg]", "[\N{DEGREE SIGN}]")
    content = f"# messung in der k\u00e4lte\n{text}".encode("cp1252")
    files = tiny_files() | {"test.csv": content}
    assert agrees(read_dataset(write_files(tmp_path / "x", files)).test[0], plain)
    (table,) = read_log(tmp_path / "x/test.csv").tables
    assert table.text == ("read as Windows-1252 text",)
    # A byte that no letter has in it, in the third line.
    rows = content.splitlines(keepends=True)
    files["test.csv"] = b"".join([*rows[:2], b"\x81", *rows[2:]])
    error = refused(write_files(tmp_path / "y", files))
    assert error.row == 3
    assert "save the file as UTF-8" in str(error)


def clocked(t: np.ndarray, form: str) -> list[str]:
    start = pd.Timestamp("2026-01-31T23:59:59")
    return [f"{start + pd.Timedelta(since, unit='s'):{form}}" for since in t]


@pytest.mark.parametrize(
    "form",
    [
        "%Y-%m-%dT%H:%M:%S.%f",
        "%Y-%m-%d %H:%M:%S.%fZ",
        "%H:%M:%S.%f",
        "%m/%d/%Y %I:%M:%S.%f %p",
        "%d.%m.%Y %H:%M:%S.%f",
    ],
)
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_times_that_are_written_out(tmp_path, plain, form, kind):
    frame = pd.read_csv(io.BytesIO(tiny_files()["test.csv"]))
    frame["t"] = clocked(frame["t"].to_numpy(), form)
    files = tiny_files()
    folder = write_files(tmp_path / "x", files)
    if kind == "csv":
        frame.to_csv(folder / "test.csv", index=False)
    else:
        frame.to_parquet(folder / "test.parquet")
        (folder / "dataset.toml").write_text(MANIFEST.replace("test.csv", "test.parquet"))
    read = read_dataset(folder).test[0]
    assert np.allclose(read.t - read.t[0], plain.t - plain.t[0], rtol=0, atol=1e-9)
    assert np.array_equal(read.q, plain.q)


def test_rows_without_names_may_begin_with_a_time(tmp_path):
    """As `date` and a logger print them; columns then have numbers."""
    rows = ["2026-01-31;10:20:30,5;0,1", "2026-01-31;10:20:30,6;0,2", ""]
    (tmp_path / "log.csv").write_text("\n".join(rows))
    (table,) = read_log(tmp_path / "log.csv").tables
    assert table.columns == ("1", "2", "3")
    assert table.take(["2"])["2"].tolist() == [37230.5, 37230.6]


def test_a_cell_that_is_no_time_among_times_is_named(tmp_path):
    frame = pd.read_csv(io.BytesIO(tiny_files()["test.csv"]))
    times = clocked(frame["t"].to_numpy(), "%H:%M:%S.%f")
    times[11] = "23:99:00"
    frame["t"] = times
    files = tiny_files() | {"test.csv": frame.to_csv(index=False).encode()}
    error = refused(write_files(tmp_path, files))
    assert (error.row, error.column) == (13, "t")
    assert "10:20:30.5" in str(error)


def test_text_in_a_parquet_column_of_times_is_named(tmp_path):
    pd.DataFrame({"t": ["10:00:00", "soon"], "q_1": [0.0, 1.0]}).to_parquet(tmp_path / "a.parquet")
    (table,) = read_log(tmp_path / "a.parquet").tables
    with pytest.raises(DataSetError, match="'soon'") as caught:
        table.take(["t"])
    assert caught.value.row == 2


def test_units_proposed_from_such_names_are_written_down(tmp_path):
    """The manifest of an import says what holds, beside the names that said it."""
    rng = np.random.default_rng(0)
    t = np.arange(0, 8, 0.02)
    q = np.rad2deg(np.column_stack([np.sin(t), np.cos(1.3 * t)]))
    names = ["time / s", "q 1 / deg", "q 2 / deg", "tau 1 / Nm", "tau 2 / Nm"]
    table = np.column_stack([t, q, rng.normal(size=q.shape)])
    pd.DataFrame(table, columns=names).to_csv(tmp_path / "log.csv", index=False)
    out = tmp_path / "set"
    assert oed("import", tmp_path / "log.csv", "--robot", "builtin:imi_scara", "--out", out) == 0
    stated = tomllib.loads((out / "dataset.toml").read_text())
    assert stated["units"]["q"] == "deg"
    assert stated["columns"]["q"] == ["q 1 / deg", "q 2 / deg"]
