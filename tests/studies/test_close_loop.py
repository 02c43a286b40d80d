"""The interface of `oed diagnose`: what it leaves, and how it refuses."""

import dataclasses
import json
from html import unescape

import numpy as np
import pytest

from oed.estimation.base_model import choose_base_model
from oed.experiment.drive import Drive
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.write_dataset import write_dataset
from tests.diagnosis.arm import data_set, stribeck
from tests.running import oed

VERDICTS = ("nothing found", "explained", "ambiguous", "unexplained")


def test_leaves_a_diagnosis_in_the_agreed_form(tmp_path):
    write_dataset(data_set(0, extra=stribeck(1.0)), tmp_path / "data")
    out = tmp_path / "out"
    status = oed(
        "diagnose", tmp_path / "data", "--out", out, "--candidates", "stribeck", "joint_spring"
    )
    assert status == 0
    record = json.loads((out / "diagnosis.json").read_text())
    assert record["format"] == 1
    assert record["verdict"] in VERDICTS
    assert len(record["joints"]) == 2
    effect = record["effects"][0]
    assert (effect["name"], effect["joint"]) == ("stribeck", 0)
    assert {"value", "std", "unit"} == set(effect["parameters"]["Fs_1"])
    assert {"name", "joint", "probability"} <= set(effect["alternatives"][0])
    for kind in ("rms", "relative_rms"):
        for when in ("before", "after", "noise_floor"):
            assert set(record[kind][when]) == {"estimation", "validation", "test"}
            assert len(record[kind][when]["test"]) == 2
    assert record["rms"]["after"]["test"][0] < record["rms"]["before"]["test"][0]
    page = (out / "report.html").read_text()
    assert f"{record['verdict'].capitalize()}: " in page
    assert "stribeck (joint 1)" in page
    following = record["next_experiment"]
    assert (following is not None) == (record["verdict"] == "ambiguous")
    if following is not None:
        assert (out / following / "trajectory.csv").is_file()
        promise = json.loads((out / following / "design.json").read_text())
        assert promise["separation"] > 0


def test_leaves_a_budget_and_what_the_test_recordings_say(tmp_path, capsys):
    dataset = data_set(0, extra=stribeck(1.5, 0.15), repetitions=2)
    write_dataset(dataset, tmp_path / "data")
    given = (tmp_path / "data", "--out", tmp_path / "out")
    names = ("--candidates", "stribeck", "torque_offset", "joint_spring")
    assert oed("diagnose", *given, *names) == 0
    record = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    (effect,) = record["effects"]
    assert (effect["name"], effect["joint"]) == ("stribeck", 0)
    assert {"name", "joint", "probability", "contender"} <= set(effect["alternatives"][0])
    assert record["contradicted"] == []
    budget = record["budget"]
    assert budget["recordings"] == "validation"
    assert budget["rms"]["stribeck@1"][0] > budget["rms"]["stribeck@1"][1] == 0
    assert record["rms"]["after"]["test"][0] < record["rms"]["before"]["test"][0]
    page = unescape((tmp_path / "out" / "report.html").read_text())
    for words in ("Torque budget", "stribeck, joint 1", "the test recordings had none"):
        assert words in page
    assert "verdict: " in capsys.readouterr().out


def test_a_pause_of_the_log_is_told_on_screen_on_the_page_and_in_the_record(tmp_path, capsys):
    write_dataset(data_set(0, roles=("estimation", "test")), tmp_path / "data")
    (file,) = (tmp_path / "data").glob("test*.csv")
    lines = file.read_text().splitlines()
    file.write_text("\n".join([*lines[:1001], *lines[1401:]]) + "\n")
    out = tmp_path / "out"
    given = ["diagnose", str(tmp_path / "data"), "--out", str(out), "--smoke"]
    assert oed(*given, "--candidates", "torque_offset") == 0
    pause = "1 gap(s) in the log's time"
    assert pause in capsys.readouterr().out
    assert "Notes on the data" in (page := unescape((out / "report.html").read_text()))
    assert pause in page
    assert pause in json.loads((out / "diagnosis.json").read_text())["data_notes"][0]


def test_says_what_is_wrong_with_a_missing_data_set(tmp_path, capsys):
    status = oed("diagnose", tmp_path / "none", "--out", tmp_path / "out")
    assert status == 2
    assert "no such folder" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_names_only_candidates(tmp_path):
    write_dataset(data_set(0, extra=stribeck(1.0)), tmp_path / "data")
    given = ["diagnose", str(tmp_path / "data"), "--out", str(tmp_path / "out"), "--smoke"]
    assert oed(*given, "--candidates", "torque_offset", "joint_spring") == 0
    record = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert not [e for e in record["effects"] if e["name"] == "stribeck"]


def test_refuses_a_candidate_that_the_catalogue_lacks(tmp_path, capsys):
    write_dataset(data_set(0), tmp_path / "data")
    given = ["diagnose", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    assert oed(*given, "--candidates", "gremlin") == 2
    assert "there is no effect gremlin" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("option", "value"), [("--max-effects", "-1"), ("--seed", "-1")])
def test_refuses_numbers_that_make_no_sense(tmp_path, capsys, option, value):
    write_dataset(data_set(0), tmp_path / "data")
    given = ["diagnose", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    assert oed(*given, option, value) == 2
    told = capsys.readouterr().err
    assert option in told
    assert value in told
    assert not (tmp_path / "out").exists()


def test_one_rule_says_which_model_is_the_base():
    """Rotor inertias where gears are declared and the data tell of one."""
    rotors = np.array([0.0, 0.05])

    def base(drive, extra):
        found = dataclasses.replace(
            data_set(0, roles=("estimation",), extra=lambda _q, _dq, ddq: extra * ddq), drive=drive
        )
        return choose_base_model(found, choose_settings(found.recordings))

    geared = Drive(gear_ratio=np.array([101.0, 50.0]))
    assert base(Drive(), rotors)[0] == "standard"
    assert base(geared, rotors) == ("rotor", "drives have gears, and the data determine Ia_2")
    assert base(geared, 0 * rotors)[0] == "standard"
    assert base(Drive(gear_ratio=np.ones(2)), rotors)[0] == "standard"
