"""What the search for a design keeps to: its seed, its budget, its criterion, its bound."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oed.design.default_problem import ProblemSettings, default_problem
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot, imi_scara
from tests.design.primitive_arm import arm_and_post
from tests.studies.designed import designed, experiment_information


def test_the_same_seed_and_evaluations_give_the_same_motion(tmp_path: Path) -> None:
    wishes = ("--robot", "builtin:imi_scara", "--evaluations", "60", "--criterion", "J_k")
    first, one = designed(tmp_path / "1", *wishes)
    second, two = designed(tmp_path / "2", *wishes)
    other, _ = designed(tmp_path / "3", *wishes, "--seed", "1", "--evaluations", "10")
    assert first["coefficients"] == second["coefficients"]
    pd.testing.assert_frame_equal(one, two, check_exact=True)
    assert first["coefficients"] != other["coefficients"]
    assert first["evaluations"] == second["evaluations"] == 60
    assert first["evaluations_asked"] == 60
    assert first["criterion"] == "J_k"
    assert first["J_k_scaled"] is None


def test_evaluations_beyond_those_asked_for_are_told_with_the_reason(tmp_path: Path) -> None:
    arm_and_post(tmp_path, post=0.35)
    for evaluations, beyond in ((8, 1), (100, 0)):
        wishes = ("--robot", str(tmp_path / "planar.urdf"), "--evaluations", str(evaluations))
        record, _ = designed(tmp_path / str(evaluations), *wishes, "--seed", "1")
        assert record["evaluations"] == evaluations + beyond
        reason = f"1 evaluation beyond the {evaluations} of --evaluations, until a motion was clear"
        assert (reason in record["notes"]) == (beyond == 1)
        assert "budget used up" not in record["status"]


def test_a_budget_that_ends_the_search_first_is_said(tmp_path: Path) -> None:
    wishes = ("--robot", "builtin:imi_scara", "--evaluations", "1000000", "--budget", "0.01")
    record, _ = designed(tmp_path, *wishes)
    assert "stopped by --budget 0.01 CPU s" in " ".join(record["notes"])


def test_scaled_columns_do_not_depend_on_the_seed(tmp_path: Path) -> None:
    arguments = ("--robot", "builtin:imi_scara", "--criterion", "J_k", "--scaled-columns")
    arguments += ("--margin", "1")  # for which `scaling_of` scales
    records = [designed(tmp_path / s, *arguments, "--seed", s)[0] for s in ("0", "1")]
    assert all(record["criterion"] == "J_k_scaled" for record in records)
    scale = scaling_of(imi_scara())
    for record in records:
        information = experiment_information(record)
        truth = np.linalg.cond(information * np.outer(scale, scale))
        assert record["J_k_scaled"] == pytest.approx(truth, rel=1e-6)
        assert record["J_k"] == pytest.approx(np.linalg.cond(information), rel=1e-6)


def scaling_of(robot: Robot) -> np.ndarray:
    settings = ProblemSettings(instants=40, criterion="J_k", scaled=True)
    scaling = default_problem(TorqueModel.standard(robot), settings).problem.scaling
    assert scaling is not None
    return scaling


def test_a_bound_that_fails_leaves_the_motion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object, **__: object) -> None:
        raise np.linalg.LinAlgError("Matrix is not positive definite")

    monkeypatch.setattr("oed.design.bound.efficiency.information_bound", fails)
    monkeypatch.setattr("oed.design.bound.efficiency.estimated_bound", fails)
    record, _ = designed(tmp_path, "--robot", "builtin:imi_scara")
    assert record["d_efficiency"] is None
    assert "no bound was found: Matrix is not positive definite" in " ".join(record["notes"])
