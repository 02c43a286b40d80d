"""A time in two columns, whole seconds and the nanoseconds beyond them, is one column of time."""

import numpy as np
import pandas as pd
import pytest

from oed.errors import DataSetError
from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.experiment.logs.registry import read_log
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import simulate, write_urdf

SINCE = 1_760_000_000  # [s] since 1970, as ROS has it
START = SINCE % 86_400


def stamped(t, sec, nanosec):
    stamps = np.round(t * 1e9).astype(np.int64)
    return {sec: SINCE + stamps // 10**9, nanosec: stamps % 10**9}


@pytest.mark.parametrize(
    ("sec", "nanosec", "named"),
    [
        ("header.stamp.sec", "header.stamp.nanosec", "header.stamp"),
        ("/joint_states/header/stamp/secs", "/joint_states/header/stamp/nsecs", None),
        ("sec", "nsec", "stamp"),
    ],
)
def test_it_is_told_to_the_nanosecond(sec, nanosec, named, tmp_path):
    t = 0.5 + 0.008 * np.arange(500)
    pd.DataFrame({**stamped(t, sec, nanosec), "q_1": t}).to_csv(tmp_path / "log.csv", index=False)
    (table,) = read_log(tmp_path / "log.csv").tables
    named = named or "/joint_states/header/stamp"
    assert table.columns == (named, "q_1")
    assert table.take([named])[named] == pytest.approx(START + t, abs=1e-9, rel=0)


def test_an_import_takes_it_for_time(tmp_path):
    urdf = write_urdf(tmp_path / "arm.urdf")
    truth = simulate(load_robot(urdf), rows=300)
    columns = stamped(truth.t, "header.stamp.sec", "header.stamp.nanosec")
    for name, values in (("q", truth.q), ("tau", truth.tau)):
        columns |= {f"{name}_{j + 1}": values[:, j] for j in range(3)}
    pd.DataFrame(columns).to_csv(tmp_path / "log.csv", index=False)
    proposal = propose_import(
        [tmp_path / "log.csv"], ImportChoices(str(urdf), name="set"), tmp_path / "set"
    )
    found_columns = proposal.content["columns"]
    assert isinstance(found_columns, dict)
    assert found_columns["t"] == "header.stamp"
    (found, *_) = proposal.dataset.recordings
    assert np.diff(found.t) == pytest.approx(np.diff(truth.t)[: len(found.t) - 1], abs=1e-8)


def test_two_clocks_of_their_own_are_not_added_up(tmp_path):
    t = 0.008 * np.arange(50)
    pd.DataFrame({"sec": t, "nsec": 1e9 * t, "q_1": t}).to_csv(tmp_path / "log.csv", index=False)
    (table,) = read_log(tmp_path / "log.csv").tables
    with pytest.raises(DataSetError, match="'nsec': remove one of both"):
        table.take(["stamp"])


def test_a_row_without_one_of_them_has_no_time(tmp_path):
    frame = pd.DataFrame({**stamped(np.arange(4.0), "sec", "nanosec"), "q_1": 1.0})
    frame.loc[2, "nanosec"] = np.nan
    frame.to_csv(tmp_path / "log.csv", index=False)
    (table,) = read_log(tmp_path / "log.csv").tables
    assert np.isnan(table.read(["stamp"])["stamp"]).tolist() == [False, False, True, False]
