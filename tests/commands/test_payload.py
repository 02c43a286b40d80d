"""`oed payload` as a user runs it, on a two-joint arm in a vertical plane."""

import dataclasses
import json
import shutil

import pytest

from oed.commands.from_data_set import held_out_notes, prepare
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording, Role
from oed.experiment.write_dataset import write_dataset
from tests.commands.vertical_arm import CENTRE, MASS, write_sets
from tests.running import oed


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    home = tmp_path_factory.mktemp("sets")
    write_sets(home)
    return home


def weigh(folders, out, *more):
    status = oed(
        "payload", "--loaded", folders / "loaded", "--torque-model", "standard",
        "--quiet", "--out", out, *more,
    )  # fmt: skip
    assert status == 0
    return json.loads((out / "payload.json").read_text(encoding="utf-8"))


def test_both_logs_weigh_the_load_and_leave_every_file(folders, tmp_path, capsys):
    found = weigh(folders, tmp_path / "out", "--bare", folders / "bare")
    assert found["route"] == "both logs"
    (mass,) = (q for q in found["quantities"] if q["name"] == "mass")
    assert mass["interval"][0] <= MASS <= mass["interval"][1]
    assert found["mass"] == pytest.approx(MASS, rel=0.03)
    assert found["centre_of_mass"][:2] == pytest.approx(CENTRE[:2], abs=0.01)
    assert {each["name"] for each in found["not_told"]} >= {"z", "Ixx", "Ixy"}
    assert sorted(p.name for p in (tmp_path / "out").iterdir() if p.is_file()) == [
        "load.script", "load.sdf", "load.urdf", "load.xml", "load_message.yaml", "payload.json",
        "report.html",
    ]  # fmt: skip
    told = capsys.readouterr().out
    assert "both logs" in told
    assert "without it the mass would be" in told


def test_a_model_from_identify_weighs_it_too(folders, tmp_path):
    identified = tmp_path / "identified"
    assert (
        oed("identify", folders / "bare", "--model", "standard", "--quiet", "--out", identified)
        == 0
    )
    found = weigh(folders, tmp_path / "out", "--model", identified / "model.json")
    assert found["route"] == "model"
    assert found["mass"] == pytest.approx(MASS, rel=0.03)


@pytest.mark.parametrize("spoilt", ["loaded", "bare"])
def test_logs_of_two_units_weigh_nothing(folders, tmp_path, spoilt, capsys):
    """Torques of one are a thousandth: no load explains that, of whatever mass."""
    for name in ("loaded", "bare"):
        shutil.copytree(folders / name, tmp_path / name)
    manifest = tmp_path / spoilt / "dataset.toml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(
        text.replace('"measured"', '"measured"\nunits = {tau = "mN m"}'), encoding="utf-8"
    )
    status = oed(
        "payload", "--loaded", tmp_path / "loaded", "--bare", tmp_path / "bare", "--quiet",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 2
    assert "at every joint: one of them is in another unit" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_placeholders_of_the_robot_file_are_no_arm(folders, tmp_path, capsys):
    status = oed("payload", "--loaded", folders / "loaded", "--quiet", "--out", tmp_path / "out")
    assert status == 3
    assert "placeholders" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (("[0.0, -9.81, 0.0]", "[0.0, 0.0, -9.81]"), "mounted"),
        (('torque = "measured"', 'torque = "commanded"'), "commanded"),
        (('joints = ["joint_1", "joint_2"]', 'joints = ["joint_2", "joint_1"]'), "joint"),
        (('torque = "measured"', 'torque = "current"\nunits = {tau = "A"}'), "oed gains"),
    ],
)
def test_folders_that_do_not_fit_are_refused_in_one_line(folders, tmp_path, change, line, capsys):
    other = tmp_path / "other"
    shutil.copytree(folders / "bare", other)
    manifest = other / "dataset.toml"
    text = " ".join(manifest.read_text(encoding="utf-8").replace(",\n]", "\n]").split("\n    "))
    text = text.replace("[ ", "[").replace("\n]", "]")
    assert change[0] in text
    manifest.write_text(text.replace(*change), encoding="utf-8")
    status = oed(
        "payload", "--bare", other, "--loaded", folders / "loaded", "--quiet",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert status in (1, 2, 3)
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert line in said
    assert not (tmp_path / "out" / "payload.json").exists()


@pytest.mark.parametrize(
    ("sign", "joints"), [("[1, -1]", ["joint_2"]), ("[-1, -1]", ["joint_1", "joint_2"])]
)
def test_a_torque_with_the_opposite_sign_is_refused_by_name(
    folders, tmp_path, sign, joints, capsys
):
    other = tmp_path / "other"
    shutil.copytree(folders / "loaded", other)
    manifest = other / "dataset.toml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(f"sign = {{tau = {sign}}}\n{text}", encoding="utf-8")
    status = oed(
        "payload", "--bare", folders / "bare", "--loaded", other, "--torque-model", "standard",
        "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 3
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "opposite sign" in said
    assert [name for name in ("joint_1", "joint_2") if name in said] == joints
    assert not (tmp_path / "out" / "payload.json").exists()


def test_a_model_of_another_robot_is_refused_in_one_line(folders, tmp_path, capsys):
    wrong = tmp_path / "model.json"
    wrong.write_text("{}", encoding="utf-8")
    status = oed(
        "payload", "--loaded", folders / "loaded", "--model", wrong, "--out", tmp_path / "o"
    )
    assert status != 0
    assert "is no model.json" in capsys.readouterr().err


def test_rows_that_are_held_out_for_nothing_are_told(folders, tmp_path, capsys):
    whole = read_dataset(folders / "loaded")
    (log,) = whole.recordings
    cut = len(log.t) * 3 // 4
    roles: tuple[tuple[Role, slice], ...] = (
        ("estimation", slice(None, cut)),
        ("test", slice(cut, None)),
    )
    parts = [Recording(role, role, log.t[k], log.q[k], log.tau[k]) for role, k in roles]
    part = tmp_path / "part"
    write_dataset(dataclasses.replace(whole, recordings=tuple(parts)), part)
    assert not held_out_notes(prepare(folders / "loaded", model="standard"))
    (note,) = held_out_notes(prepare(part, model="standard"))
    assert "25% of the rows" in note
    out = tmp_path / "out"
    more = ("--bare", folders / "bare", "--torque-model", "standard", "--quiet", "--out", out)
    assert oed("payload", "--loaded", part, *more) == 0
    assert note in capsys.readouterr().out
