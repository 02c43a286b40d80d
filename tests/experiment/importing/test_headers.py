"""Names of columns are found wherever a logger writes them above its numbers."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oed.errors import DataSetError
from oed.experiment.importing.assign_joints import RobotJoints
from oed.experiment.importing.propose_columns import ColumnProposal, propose_columns
from oed.experiment.logs import read_log

JOINTS = ("shoulder", "elbow")
NAMES = "t,q_1,q_2,tau_1,tau_2\n"
ROWS = "".join(f"{k / 100},{k},{k + 1},{k + 2},{k + 3}\n" for k in range(5))


def proposal(path: Path, **stated: tuple[str, ...]) -> ColumnProposal:
    return propose_columns(read_log(path), RobotJoints(JOINTS, JOINTS), stated)


def written(folder: Path, text: str) -> Path:
    (folder / "log.csv").write_text(text, encoding="utf-8")
    return folder / "log.csv"


@pytest.mark.parametrize(
    "above",
    [
        "Robot: TX40\nDate: 2026-05-03, 10:11:12\n\n",
        "LabVIEW Measurement,\nOperator,max\n***End_of_Header***,\n",
        "# a comment\nrate 100 Hz\nmass,0.5,1.5\n",
    ],
)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_lines_of_text_above_the_names_are_passed_over(above, separator, tmp_path):
    path = written(tmp_path, above + (NAMES + ROWS).replace(",", separator))
    found = proposal(path)
    assert found.columns["q"] == ("q_1", "q_2")
    assert np.array_equal(found.table.take(["q_2"])["q_2"], np.arange(1, 6))
    assert found.table.first_row == above.count("\n") + 2
    assert any("above the names of the columns" in note for note in found.notes)


def test_a_fault_in_the_first_rows_is_no_text_above(tmp_path):
    for fault in ("0.0,1,2,3\n", "0.0,1,2,3,4,5\n"):
        with pytest.raises(DataSetError, match="row 2"):
            proposal(written(tmp_path, NAMES + fault + ROWS))
    (table,) = read_log(written(tmp_path, NAMES + "0.0,x,1,2,3\n" + ROWS)).tables
    with pytest.raises(DataSetError, match=r"row 2.*'q_1'"):
        table.take(["q_1"])


@pytest.mark.parametrize("is_merged", [False, True])
@pytest.mark.parametrize("above", ["", "Robot: TX40\n"])
def test_names_in_two_lines(is_merged, above, tmp_path):
    upper = "t,q,,tau,\n" if is_merged else "t,q,q,tau,tau\n"
    found = proposal(written(tmp_path, f"{above}{upper},elbow,shoulder,elbow,shoulder\n{ROWS}"))
    assert found.columns["q"] == ("q.shoulder", "q.elbow")
    assert found.columns["tau"] == ("tau.shoulder", "tau.elbow")
    assert found.columns["t"] == ("t",)
    assert np.array_equal(found.table.take(["q.elbow"])["q.elbow"], np.arange(5))


def test_a_column_of_times_is_the_time_whatever_it_is_called(tmp_path):
    times = pd.to_datetime(1_760_000_000_000_000_000 + 10_000_000 * np.arange(5))
    frame = pd.DataFrame({name: np.arange(5.0) for name in ("q_1", "q_2", "tau_1", "tau_2")})
    frame.set_index(times).to_parquet(tmp_path / "log.parquet")
    found = proposal(tmp_path / "log.parquet")
    assert found.columns["t"] == ("__index_level_0__",)
    frame.insert(2, "Recorded at", times.strftime("%Y-%m-%d %H:%M:%S.%f"))
    frame.to_csv(tmp_path / "log.csv", index=False)
    found = proposal(tmp_path / "log.csv")
    (name,) = found.columns["t"]
    assert np.diff(found.table.take([name])[name]) == pytest.approx(0.01, abs=1e-9)
    frame["time"] = np.arange(5.0)
    frame.to_csv(tmp_path / "log.csv", index=False)
    assert proposal(tmp_path / "log.csv").columns["t"] == ("time",)
    frame.drop(columns="time").assign(saved=frame["Recorded at"]).to_csv(
        tmp_path / "log.csv", index=False
    )
    assert "t" not in proposal(tmp_path / "log.csv").columns


@pytest.mark.parametrize("unit", ["(%)", "[‰]", "in percent"])
def test_a_share_of_what_a_drive_is_rated_for_is_no_torque(unit, tmp_path):
    text = f"t,q_1,q_2,trq 1 {unit},trq 2 {unit}\n{ROWS}"
    with pytest.raises(DataSetError, match="multiply each joint's column by its rated torque"):
        proposal(written(tmp_path, text), tau=(f"trq 1 {unit}", f"trq 2 {unit}"))


@pytest.mark.parametrize("cell", ["inf", "ERR"])
def test_a_cell_without_a_number_may_be_left_empty(cell, tmp_path):
    (table,) = read_log(written(tmp_path, f"{NAMES}0,1,2,3,{cell}\n{ROWS}")).tables
    with pytest.raises(DataSetError, match=r"row 2.*'tau_2'.*leave them empty"):
        table.take(["tau_2"])
    (table,) = read_log(written(tmp_path, f"{NAMES}0,1,2,3,\n{ROWS}")).tables
    assert np.isnan(table.read(["tau_2"])["tau_2"]).tolist() == [True] + 5 * [False]
