"""Studies of one question each, at smoke size."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from oed.experiment.read_dataset import read_dataset
from oed.report.json_file import read_json
from oed.report.table import read_csv
from studies import (
    condition_bound,
    cross_check,
    rollout_error,
    rollout_summary,
    scara_recordings,
    streaming,
    undeclared_masses,
)
from studies.data_folders import data_sets
from tests.paths import REPO
from tests.running import oed


def test_cross_check_agrees_and_says_with_what(tmp_path: Path) -> None:
    assert cross_check.main(["--smoke", "--out", str(tmp_path)]) == 0
    rows = read_csv(tmp_path / "runs.csv")
    assert [row["robot"] for row in rows] == ["imi_scara", "ur5_robot"]
    assert [row["base_torque"] for row in rows] == [4, 36]
    assert all(row["agrees"] for row in rows)
    assert read_json(tmp_path / "provenance.json")["versions"]["drake"]


def test_cross_check_of_a_file_that_is_no_robot_leaves_nothing(tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    assert oed("cross-check", tmp_path / "absent.urdf", "--out", out) == 2
    assert "no such robot file" in capsys.readouterr().err
    assert not out.exists()


def test_cross_check_leaves_nothing_where_no_folder_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert oed("cross-check", "builtin:imi_scara", "--states", 50) == 0
    assert not list(tmp_path.iterdir())


def test_the_arm_of_undeclared_masses_has_other_bodies_and_declares_nothing() -> None:
    config = undeclared_masses.Config(seconds=4.0)
    dataset, truth = undeclared_masses.simulate(config, 62)
    declared = dataset.robot.parameters[::10]
    assert np.all((truth / declared >= 0.8) & (truth / declared <= 1.25))
    assert not np.allclose(truth, declared, rtol=0.02)
    assert [r.role for r in dataset.recordings] == list(undeclared_masses.ROLES)
    # Steps that `oed calibrate` takes are tested where they are; what they come to is read here.
    row = {"seed": 62, "link": "l", "truth [kg]": 2.0, "feasible alone [kg]": 0.5}
    told = undeclared_masses.summarise([row | {"calibrate [kg]": 2.2}])
    assert "4 by `oed feasible` alone, 1.1 by `oed calibrate`" in told


def test_rollouts_say_whether_the_claim_is_kept_and_who_has_no_simulation() -> None:
    row = dict.fromkeys((*rollout_error.KEY, *rollout_error.VALUES), "")
    row |= {
        "arm": "one",
        "status": "done",
        "windows": "4",
        "horizons": "0.1 2",
        "second_round": "0",
    }
    row |= {
        "flange_mm_file": "20 200",
        "flange_mm_base_bodies": "1 20",
        "flange_mm_feasible": "2 30",
    }
    row |= {"not_simulated_base": "the mass matrix has the eigenvalue -1"}
    told = rollout_summary.verdict(row)
    assert told.startswith("one: 30 mm after 2 s, 0.15 of the file's (at most 0.2: kept)")
    assert "1.5 of the base's in bodies (at most 1: not kept)" in told
    failed = row | {"arm": "two", "status": "failed: too short"}
    page = rollout_summary.page([row, failed])
    assert "| one | base | – | – | the mass matrix has the eigenvalue -1 |" in page
    assert "- two: failed: too short" in page


def test_streaming_finds_the_truth(tmp_path: Path) -> None:
    assert streaming.main(["--smoke", "--out", str(tmp_path)]) == 0
    row = read_csv(tmp_path / "runs.csv")[0]
    # 57 parameters: the largest of as many standard normal errors exceeds 5 once in 30,000 runs.
    assert row["worst_error_in_std"] < 5.0
    assert row["samples"] == 20_000


def test_hidden_effect_changes_the_torque_and_is_not_declared(tmp_path: Path) -> None:
    sets = {}
    for hidden in ("cable", "none"):
        folder = tmp_path / hidden
        assert scara_recordings.main(["--smoke", "--out", str(folder), "--hidden", hidden]) == 0
        text = "".join(p.read_text() for p in folder.glob("*.toml"))
        assert "cable" not in text
        sets[hidden] = read_dataset(folder)
    with_cable, without = (s.estimation[0] for s in sets.values())
    assert with_cable.repetition is not None
    assert len(np.unique(with_cable.repetition)) == 2
    # Same seed, same disturbance: what differs on joint 2 is the cable, 1.2 N m/rad over 1.5 rad.
    difference = np.ptp(with_cable.tau[:, 1] - without.tau[:, 1])
    assert 0.5 < difference < 4.0


@pytest.mark.parametrize("count", [1, 2])
def test_data_sets_are_found_alone_or_in_a_folder(tmp_path: Path, count: int) -> None:
    for name in ("a", "b")[:count]:
        (tmp_path / name).mkdir()
        (tmp_path / name / "dataset.toml").touch()
    assert [p.name for p in data_sets(tmp_path)] == ["a", "b"][:count]
    assert data_sets(tmp_path / "a") == (tmp_path / "a",)


@pytest.mark.skipif(
    importlib.util.find_spec("figaroh") is not None, reason="figaroh is installed here"
)
def test_the_script_for_another_environment_says_what_it_lacks() -> None:
    run = subprocess.run(
        [sys.executable, "-m", "studies.figaroh_design"],
        check=False,
        capture_output=True,
        text=True,
        cwd=REPO,
    )
    assert run.returncode == 2
    assert "has no package figaroh" in run.stderr
    assert run.stderr.count("\n") == 1


def test_a_bound_on_the_condition_number_is_left_with_what_it_ignores(tmp_path: Path) -> None:
    assert condition_bound.main(["--smoke", "--out", str(tmp_path)]) == 0
    (row,) = read_csv(tmp_path / "runs.csv")
    assert float(row["J_k_bound"]) == pytest.approx(0.4 * float(row["J_k_of_best_measure"]))
    assert "ignores that states lie on one trajectory" in (tmp_path / "summary.md").read_text()
