"""`oed design --robust` as a user runs it."""

import dataclasses
import json

import numpy as np
import pytest

from oed.export.model import ShapeEstimate
from oed.export.model_file import write_model
from tests.export.every_effect import model_with
from tests.running import oed

FEW = ("--evaluations", "30")
QUICK = ("--horizon", "3", "--smoke", "--quiet", "--no-clearance", "--scenarios", "3")


def model_of(*, doubtful):
    """Of possible bodies that are known to a share, with a Stribeck speed known to a third."""
    model, _ = model_with("stribeck", duration=0.2)
    std = 0.02 * np.abs(model.parameters)
    speed = model.torque_model.effects[-1].speed
    own = (ShapeEstimate("speed", "rad/s", speed, speed / 3 if doubtful else 0.0),)
    shapes = (*[()] * (len(model.torque_model.effects) - 1), own)
    return dataclasses.replace(model, covariance=np.diag(std**2), estimated=std > 0, shapes=shapes)


def design(model, folder, *options):
    path = write_model(model, folder / "model.json")
    status = oed("design", "--model", path, *QUICK, *options, "--out", folder / "out")
    return status, folder / "out"


def record_of(out):
    return json.loads((out / "design.json").read_text(encoding="utf-8"))


def test_both_motions_are_left_side_by_side(tmp_path):
    status, out = design(model_of(doubtful=True), tmp_path, "--robust", "worst", *FEW)
    assert status == 0
    robust = record_of(out)["robust"]
    assert robust["aim"] == "worst"
    assert robust["scenarios"] == 3
    assert robust["has_shapes"]
    nominal, found = robust["nominal_design"], robust["robust_design"]
    for each in (nominal, found):
        assert each["worst"] < each["expected"]  # of J_d, which is to be large
    assert found["worst"] >= nominal["worst"]
    assert any("speed of stribeck" in note for note in record_of(out)["notes"])
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "What doubt costs" in page
    assert "3 drawn models" in page


def test_the_same_seed_gives_the_same_models(tmp_path):
    (tmp_path / "again").mkdir()
    options = ("--robust", "expected", *FEW)
    found = [
        record_of(design(model_of(doubtful=True), folder, *options)[1])["robust"]
        for folder in (tmp_path, tmp_path / "again")
    ]
    assert found[0] == found[1]


def test_nothing_that_counts_in_doubt_is_refused(tmp_path, capsys):
    status, _ = design(model_of(doubtful=False), tmp_path, "--robust", "worst")
    assert status == 3
    assert "nothing in this design depends on what the model leaves in doubt" in (
        capsys.readouterr().err
    )


def test_base_parameters_are_no_bodies_to_draw(tmp_path, capsys):
    model = model_of(doubtful=True)
    parameters = model.parameters.copy()
    parameters[10] = 0.0
    model = dataclasses.replace(model, parameters=parameters)
    status, _ = design(model, tmp_path, "--robust", "worst")
    assert status == 3
    assert "--robust" in (told := capsys.readouterr().err)
    assert "oed feasible" in told


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--robot", "builtin:imi_scara"), "give what is in doubt"),
        (("--robot", "builtin:imi_scara", "--payload"), "--payload"),
    ],
)
def test_without_what_is_in_doubt_it_is_refused(given, said, tmp_path, capsys):
    assert oed("design", *given, "--robust", "worst", "--out", tmp_path / "out") == 2
    assert said in capsys.readouterr().err
