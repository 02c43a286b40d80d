"""`oed calibrate`: what the model lacks does not end up in masses, and one page links everything."""

import re

import numpy as np
import pytest

from oed.experiment.write_dataset import write_dataset
from oed.export.model_file import load_model
from oed.report.json_file import read_json
from oed.robot import imi_scara
from tests.commands.test_start_from_model import SPRING, pull
from tests.diagnosis.arm import data_set
from tests.running import oed


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibrate")
    write_dataset(data_set(52, extra=pull, repetitions=2), folder / "data")
    told = ("--model", "standard", "--smoke", "--quiet", "--to", "c")
    few = ("--candidates", "joint_spring", "torque_offset", "stribeck")
    assert oed("calibrate", folder / "data", "--out", folder / "out", *told, *few) == 0
    return folder / "out"


def test_one_page_links_everything(calibrated):
    page = (calibrated / "index.html").read_text(encoding="utf-8")
    linked = re.findall(r'<a href="([^"#]+)"', page)
    assert len(linked) >= 5
    assert all((calibrated / address).is_file() for address in linked)
    assert "joint_spring (joint 2)" in page


def test_bodies_are_estimated_beside_what_was_found(calibrated):
    model = load_model(calibrated / "feasible" / "model.json")
    assert model.is_feasible
    values = dict(
        zip((p.name for p in model.torque_model.parameters), model.parameters, strict=True)
    )
    assert values["spring_2"] == pytest.approx(SPRING, rel=0.05)
    masses, truth = model.parameters[:20:10], imi_scara().parameters[::10]
    assert np.all((masses > truth / 1.5) & (masses < truth * 1.5))


def test_the_record_says_what_came_out(calibrated):
    record = read_json(calibrated / "calibration.json")
    assert record["effects"] == [{"name": "joint_spring", "joint": 1}]
    assert record["exports"] == {"c": ["oed_model.c", "oed_model.h"]}
    rms = record["rms"]
    assert rms["after"]["test"][1] < rms["before"]["test"][1] / 3


def test_an_unknown_form_is_refused_before_the_work(calibrated, tmp_path, capsys):
    given = (calibrated.parent / "data", "--out", tmp_path / "o", "--to", "plan9")
    assert oed("calibrate", *given) == 2
    assert "no form 'plan9'" in capsys.readouterr().err
    assert not (tmp_path / "o").exists()
