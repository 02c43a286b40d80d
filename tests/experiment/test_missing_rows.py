"""A row of a log without a number is a row that is missing: nothing else is read, and it is said."""

import numpy as np
import pandas as pd
import pytest

from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from oed.experiment.stretches import gap_lengths
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import simulate, write_urdf
from tests.experiment.tiny_dataset import refused, spoil, tiny_files, write_files
from tests.running import oed

MISSING = [4, 5, 11]  # rows of the tiny log, from 0


@pytest.fixture
def frame(tmp_path) -> pd.DataFrame:
    return smooth(pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv"))


def smooth(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows with positions that an arm can take at these times."""
    return frame.assign(**{f"q_{j}": np.sin(j * frame["t"]) for j in (1, 2)})


def read(folder, frame: pd.DataFrame, suffix: str = ".csv") -> Recording:
    spoil(folder, "dataset.toml", "test.csv", f"test{suffix}")
    if suffix == ".csv":
        frame.to_csv(folder / "test.csv", index=False)
    else:
        frame.to_parquet(folder / "test.parquet", index=False)
    return read_dataset(folder).test[0]


def assert_same(found: Recording, expected: Recording) -> None:
    for name in ("t", "q", "tau", "dq", "temperature"):
        one, other = getattr(found, name), getattr(expected, name)
        assert (one is None) == (other is None), name
        assert one is None or np.array_equal(one, other), name


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("column", ["t", "q_2", "tau_1", "dq_1", "temperature_1"])
def test_it_is_read_as_the_log_without_that_row(tmp_path, frame, suffix, column):
    for j in (1, 2):
        frame[f"dq_{j}"] = j * np.cos(j * frame["t"])
    frame["temperature_1"] = 20 + frame["t"]
    expected = read(tmp_path, frame.drop(index=MISSING))
    frame.loc[MISSING, column] = np.nan
    found = read(tmp_path, frame, suffix)
    assert_same(found, expected)
    first = MISSING[0] + (2 if suffix == ".csv" else 1)
    (note,) = found.notes
    assert note.endswith(
        f"3 rows without a number, taken as missing: 3 in column {column}; the first of them row {first}"
    )


@pytest.mark.parametrize("cell", ["", " ", "NaN", "-nan"])
def test_however_it_is_written(tmp_path, frame, cell):
    expected = read(tmp_path, frame.drop(index=MISSING))
    texts = frame.astype(str)
    texts.loc[MISSING, ["q_1", "tau_2"]] = cell
    found = read(tmp_path, texts)
    assert_same(found, expected)
    assert "3 in columns q_1 … tau_2; the first" in found.notes[0]


def test_columns_that_lack_different_rows_are_told_apart(tmp_path, frame):
    frame.loc[[3], "q_1"] = np.nan
    frame.loc[[3, 4], "tau_2"] = np.nan
    found = read(tmp_path, frame)
    assert len(found.t) == len(frame) - 2
    assert "2 rows without a number" in found.notes[0]
    assert "1 in column q_1, 2 in column tau_2; the first of them row 5" in found.notes[0]


def test_rows_that_repeat_are_told_beside_those_that_are_missing(tmp_path, frame):
    frame.loc[7] = frame.loc[6]
    frame.loc[3, "q_1"] = np.nan
    missing, repeated = read(tmp_path, frame).notes
    assert "1 row without a number" in missing
    assert "without 1 row that repeats the row before exactly" in repeated


def test_a_run_of_them_is_a_gap(tmp_path, frame):
    frame["t"] /= 100  # 1 kHz
    frame = pd.concat([frame.assign(t=frame["t"] + 0.03 * k) for k in range(4)])
    frame = smooth(frame.reset_index(drop=True))
    frame.loc[40:79, "tau_1"] = np.nan
    assert gap_lengths(read(tmp_path, frame)) == pytest.approx([0.041])
    frame.loc[42:79, "tau_1"] = 0.5 + 0.001 * np.arange(38)
    assert not len(gap_lengths(read(tmp_path, frame)))


def test_without_a_column_of_time_the_others_stay_when_they_were(tmp_path, frame):
    spoil(tmp_path, "dataset.toml", 'torque = "measured"', 'torque = "measured"\nrate = 10.0')
    expected = np.delete(np.arange(len(frame)) / 10, MISSING)
    frame.loc[MISSING, "q_1"] = np.nan
    frame.to_csv(tmp_path / "test.csv", index=False)
    (tmp_path / "dataset.toml").write_text((tmp_path / "dataset.toml").read_text())
    assert np.array_equal(read_dataset(tmp_path).test[0].t, expected)


def test_a_time_that_is_missing_does_not_move_a_cut(tmp_path, frame):
    cut = 'file = "test.csv"\nfrom = 0.3\nto = 2.9'
    frame.loc[[0, 9, 29], "t"] = np.nan
    spoil(tmp_path, "dataset.toml", 'file = "test.csv"', cut)
    frame.to_csv(tmp_path / "test.csv", index=False)
    found = read_dataset(tmp_path).test[0]
    t = frame["t"].to_numpy()
    assert np.array_equal(found.t, t[(t >= 0.4) & (t < 3.0)])
    assert "1 row without a number, taken as missing: 1 in column t" in found.notes[0]


def test_a_column_that_is_logged_now_and_then_is_refused(tmp_path, frame):
    frame["temperature_1"] = np.where(frame.index % 10 == 0, 20.0, np.nan)
    frame.to_csv(tmp_path / "test.csv", index=False)
    error = refused(tmp_path)
    assert error.column == "temperature_1"
    assert "no number in 27 of 30 rows that have all others" in str(error)


def test_quantities_that_are_never_logged_together_are_refused(tmp_path, frame):
    frame.loc[::2, ["q_1", "q_2"]] = np.nan
    frame.loc[1::2, ["tau_1", "tau_2"]] = np.nan
    frame.to_csv(tmp_path / "test.csv", index=False)
    assert "no row holds a number in each of t, q_1, q_2, tau_1, tau_2" in str(refused(tmp_path))


@pytest.mark.parametrize("rate", [(), ("--rate", "100")])
@pytest.mark.parametrize("missing", ["run", "single", "every second"])
def test_an_import_divides_what_is_there(tmp_path, missing, rate):
    """As it divides the same log without those rows, such as of two sources joined by their time."""
    arm = write_urdf(tmp_path / "arm.urdf")
    truth = simulate(load_robot(arm))
    rows = {"run": range(500, 640), "single": [77], "every second": range(1, 2400, 2)}[missing]
    columns = {"time": truth.t}
    for name, values in (("q", truth.q), ("dq", truth.dq), ("tau", truth.tau)):
        columns |= {f"{name}_{j + 1}": values[:, j] for j in range(3)}
    whole = pd.DataFrame(columns)
    holed = whole.copy()
    holed.loc[list(rows), "q_1":"tau_3"] = np.nan
    whole = whole.drop(index=list(rows))
    found = {}
    for name, one, more in (("holed", holed, rate), ("whole", whole, ())):
        one.to_csv(tmp_path / f"{name}.csv", index=False)
        given = ("import", tmp_path / f"{name}.csv", "--robot", arm, "--out", tmp_path / name)
        assert oed(*map(str, given), *more) == 0
        found[name] = read_dataset(tmp_path / name).recordings
    assert len(found["holed"]) == len(found["whole"]) == 3
    for one, other in zip(found["holed"], found["whole"], strict=True):
        assert one.role == other.role
        assert np.allclose(one.t, other.t, rtol=0, atol=1e-9)
        assert np.array_equal(one.q, other.q)
        assert np.array_equal(one.tau, other.tau)
    notes = [note for one in found["holed"] for note in one.notes]
    assert any("columns q_1 … " in note for note in notes)
