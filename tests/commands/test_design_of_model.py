"""`oed design --model model.json` as a user runs it."""

import dataclasses
import json

import pytest

from oed.export.model_file import write_model
from tests.export.every_effect import model_with
from tests.running import oed

QUICK = ("--horizon", "3", "--smoke", "--quiet", "--no-clearance")


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    model, _ = model_with("joint_spring", "presliding_hysteresis", "time_delay", duration=0.2)
    return write_model(model, tmp_path_factory.mktemp("found") / "model.json")


def test_a_motion_for_a_found_model_is_left_and_what_is_left_out_is_named(path, tmp_path):
    assert oed("design", "--model", path, *QUICK, "--out", tmp_path / "out") == 0
    record = json.loads((tmp_path / "out" / "design.json").read_text(encoding="utf-8"))
    assert record["model"] == str(path)
    assert "spring_2" in record["base_parameters"]
    assert record["with_prior"] is not None
    notes = " ".join(record["notes"])
    assert "joint_spring" in notes
    for name in ("presliding_hysteresis", "time_delay"):
        assert f"{name} of {path} is left out: it " in notes
    assert (tmp_path / "out" / "motion.csv").exists()


def test_earlier_experiments_add_to_what_the_model_knows(path, tmp_path):
    assert oed("design", "--model", path, *QUICK, "--out", tmp_path / "first") == 0
    earlier = tmp_path / "first" / "design.json"
    given = ("--model", path, *QUICK, "--prior", earlier)
    assert oed("design", *given, "--out", tmp_path / "second") == 0
    first, second = (
        json.loads((tmp_path / name / "design.json").read_text(encoding="utf-8"))
        for name in ("first", "second")
    )
    assert second["with_prior"]["J_d_log10"] > first["with_prior"]["J_d_log10"]


def test_a_model_of_another_arm_is_refused(path, tmp_path, capsys):
    robot = ("--robot", "builtin:imi_scara")  # the model's lies on its side
    status = oed("design", "--model", path, *robot, *QUICK, "--out", tmp_path / "out")
    assert status != 0
    assert "mounted in another way" in capsys.readouterr().err


def test_a_model_without_covariance_is_refused(tmp_path, capsys):
    model, _ = model_with("stribeck", duration=0.2)
    bare = dataclasses.replace(model, covariance=None)
    path = write_model(bare, tmp_path / "model.json")
    assert oed("design", "--model", path, *QUICK, "--out", tmp_path / "out") != 0
    assert "has no covariance" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (("--payload",), "--arm"),
        (("--joints", "joint_1"), "--joints"),
        (("--gravity", "0", "0", "-9.8"), "--gravity"),
    ],
)
def test_what_a_model_already_says_is_refused(option, said, path, tmp_path, capsys):
    assert oed("design", "--model", path, *option, "--out", tmp_path / "out") == 2
    assert said in capsys.readouterr().err
