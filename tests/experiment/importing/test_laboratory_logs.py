"""Logs as laboratories have them, imported in one command each, give one and the same estimate."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from oed.dynamics.models import build_model
from oed.estimation.calibration import calibrate
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.read_dataset import read_dataset
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import (
    JOINTS,
    LOGS,
    TORQUE_CONSTANT,
    Truth,
    lerobot,
    simulate,
)
from tests.running import oed


@pytest.fixture(scope="module")
def truth(arm) -> Truth:
    return simulate(load_robot(arm))


def imported(log, arm, folder, *more: str) -> DataSet:
    out = folder / "set"
    assert oed("import", str(log), "--robot", str(arm), "--out", str(out), *more) == 0
    return read_dataset(out)


def estimate(dataset: DataSet) -> np.ndarray:
    model = build_model("standard", dataset.robot, sign_width=0.02)
    return calibrate(dataset, model, choose_settings(dataset.recordings)).estimate.parameters


@pytest.fixture(scope="module")
def expected(arm, truth) -> np.ndarray:
    """The estimate from the simulation's own arrays, divided by hand."""
    parts = [slice(0, 1440), slice(1440, 1920), slice(1920, 2400)]
    return estimate(
        DataSet.from_arrays(
            load_robot(arm),
            t=[truth.t[part] for part in parts],
            q=[truth.q[part] for part in parts],
            tau=[truth.tau[part] for part in parts],
            roles=("estimation", "validation", "test"),
        )
    )


@pytest.mark.parametrize("kind", LOGS)
def test_every_log_gives_the_same_estimate(kind, arm, truth, expected, tmp_path):
    log = LOGS[kind](truth, tmp_path)
    more = ["--current-to-torque", *map(str, TORQUE_CONSTANT)] if kind.startswith("RTDE") else []
    dataset = imported(log, arm, tmp_path, *more)
    assert dataset.robot.joint_names == JOINTS
    assert [r.role for r in dataset.recordings] == ["estimation", "validation", "test"]
    q = np.concatenate([r.q for r in dataset.recordings])
    assert np.allclose(q, truth.q, rtol=0, atol=1e-12)
    assert all(r.dq is not None for r in dataset.recordings)
    assert np.allclose(estimate(dataset), expected, rtol=1e-7, atol=1e-9)


def test_episodes_that_each_start_at_zero_are_a_recording_each(arm, truth, tmp_path):
    """As of LeRobot, whose files hold many, and of a logger that a laboratory started twice."""
    second = np.arange(len(truth.t)) >= 1200
    own = truth.t - np.where(second, truth.t[1200], truth.t[0])
    dataset = imported(lerobot(dataclasses.replace(truth, t=own), tmp_path), arm, tmp_path)
    assert [r.role for r in dataset.recordings] == ["estimation", "validation"]
    assert [len(r.t) for r in dataset.recordings] == [1200, 1200]
    whole = imported(
        tmp_path / "data/chunk-000/episode_000000.parquet",
        arm,
        tmp_path / "all",
        "--roles",
        "estimation",
    )
    assert [(r.name, r.role) for r in whole.recordings] == [
        ("estimation-1", "estimation"),
        ("estimation-2", "estimation"),
    ]


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_rows_before_the_drives_report_are_left_out(value, arm, truth, tmp_path, capsys):
    tau = truth.tau.copy()
    tau[:200] = value
    columns = {"time": truth.t}
    for j, name in enumerate(JOINTS):
        columns |= {f"{name} pos": truth.q[:, j], f"{name} torque": tau[:, j]}
    pd.DataFrame(columns).to_csv(tmp_path / "a.csv", index=False)
    dataset = imported(tmp_path / "a.csv", arm, tmp_path)
    assert np.array_equal(np.concatenate([r.tau for r in dataset.recordings]), truth.tau[200:])
    assert (
        "a.csv, rows 2 to 201, where the drives do not report, left out" in capsys.readouterr().out
    )
    whole = imported(tmp_path / "a.csv", arm, tmp_path / "all", "--roles", "estimation")
    assert len(whole.recordings[0].t) == len(truth.t) - 200


def test_what_is_said_of_a_column_has_the_name_of_the_log(arm, truth, tmp_path):
    tau = truth.tau.copy()
    tau[700:900, 1] = 0.0
    columns = {"time": truth.t}
    for j, name in enumerate(JOINTS):
        columns |= {f"{name} pos": truth.q[:, j], f"{name} torque": tau[:, j]}
    pd.DataFrame(columns).to_csv(tmp_path / "a.csv", index=False)
    (note,) = (n for n in imported(tmp_path / "a.csv", arm, tmp_path).notes if "stays at 0" in n)
    assert f"column '{JOINTS[1]} torque'" in note
