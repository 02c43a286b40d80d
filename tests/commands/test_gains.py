"""`oed gains` as a user runs it, on a two-joint arm in a vertical plane."""

import json
import re
import shutil
import tomllib

import numpy as np
import pytest

from tests.commands.vertical_arm import CENTRE, MASS, write_in_amperes, write_sets
from tests.running import oed

GAINS = np.array([9.0, 4.0])


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    home = tmp_path_factory.mktemp("currents")
    write_in_amperes(home, GAINS)
    return home


def find(folders, out, *more):
    status = oed(
        "gains", "--bare", folders / "bare", "--loaded", folders / "loaded",
        "--torque-model", "standard", "--quiet", "--out", out, *more,
    )  # fmt: skip
    assert status == 0
    return json.loads((out / "gains.json").read_text(encoding="utf-8"))


def test_a_known_load_gives_newton_metres_an_ampere(folders, tmp_path, capsys):
    found = find(folders, tmp_path / "out", "--mass", MASS)
    assert [g["value"] for g in found["gains"]] == pytest.approx(GAINS, rel=0.01)
    for gain, true in zip(found["gains"], GAINS, strict=True):
        lower, upper = gain["interval"]
        # One draw: twice as wide, 95 in 100 intervals become 9999 in 10000.
        assert abs(true - (lower + upper) / 2) < upper - lower
        assert gain["unit"] == "N m/A"
    drive = tomllib.loads((tmp_path / "out" / "drive.toml").read_text(encoding="utf-8"))["drive"]
    assert drive["current_to_torque"] == pytest.approx(GAINS, rel=0.01)
    told = re.search(r"load 1: 1.5 kg, centre of mass at x ([0-9.]+)", capsys.readouterr().out)
    assert told
    assert float(told[1]) == pytest.approx(50.0, rel=0.01)


def test_a_known_centre_narrows_them(folders, tmp_path):
    wide, narrow = (
        np.diff(find(folders, tmp_path / name, "--mass", MASS, *more)["gains"][1]["interval"])[0]
        for name, more in (("mass", ()), ("centre", ("--com", *CENTRE)))
    )
    assert narrow < wide


def test_without_a_mass_ratios_are_told_and_said_to_be(folders, tmp_path, capsys):
    found = find(folders, tmp_path / "out")
    assert found["reference"] == "joint_1"
    assert found["gains"][1]["value"] == pytest.approx(GAINS[1] / GAINS[0], rel=0.02)
    assert found["gains"][1]["unit"] == "of joint_1"
    assert not (tmp_path / "out" / "drive.toml").exists()
    assert "without a known mass (--mass)" in capsys.readouterr().out


def test_a_current_with_the_opposite_sign_is_refused_by_name(folders, tmp_path, capsys):
    other = tmp_path / "other"
    shutil.copytree(folders / "bare", other)
    manifest = other / "dataset.toml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(f"sign = {{tau = [-1, 1]}}\n{text}", encoding="utf-8")
    status = oed(
        "gains", "--bare", other, "--loaded", folders / "loaded", "--mass", MASS,
        "--torque-model", "standard", "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 3
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "the current of 1 joint has the opposite sign: joint_1" in said


def test_measured_torques_have_no_gains(tmp_path, capsys):
    write_sets(tmp_path)
    status = oed(
        "gains", "--bare", tmp_path / "bare", "--loaded", tmp_path / "loaded", "--mass", MASS,
        "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 3
    said = capsys.readouterr().err
    assert "there is no gain to find" in said
    assert said.count("\n") == 1


def test_a_load_that_makes_no_difference_tells_no_gain(folders, tmp_path, capsys):
    """The recording with the load is that without: a copy under the wrong name."""
    shutil.copytree(folders / "loaded", tmp_path / "copy")
    shutil.copy(folders / "bare" / "bare.csv", tmp_path / "copy" / "loaded.csv")
    status = oed(
        "gains", "--bare", folders / "bare", "--loaded", tmp_path / "copy", "--mass", MASS,
        "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 3
    assert "the currents do not differ between the data sets" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--loaded", "a"), "--bare"),
        (("--bare", "a", "--loaded", "b", "--mass", "1", "2"), "2 masses for 1 data sets"),
        (("--bare", "a", "--loaded", "b", "--com", "0", "0", "0"), "without --mass"),
        (("--bare", "a", "--loaded", "b", "--mass", "1", "--com", "0", "0"), "2 numbers"),
        (("--loaded", "a", "b/../a", "--mass", "1"), "names a data set twice"),
        (("--bare", "a", "--mass", "1"), "no data set with a load"),
        (("--bare", "a", "--loaded", "b", "--mass", "-1"), "--mass -1 is no number from 0.001"),
        (("--bare", "a", "--loaded", "b", "./a", "--mass", "1"), "both are a"),
    ],
)
def test_options_that_cannot_be_meant_are_refused_in_one_line(options, line, tmp_path, capsys):
    assert oed("gains", *options, "--out", tmp_path / "out") == 2
    said = capsys.readouterr().err
    assert line in said
    assert said.count("\n") == 1
