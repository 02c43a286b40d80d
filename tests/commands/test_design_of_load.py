"""`oed design --payload` as a user runs it."""

import csv
import json
import re

import pytest

from tests.paths import example_robot
from tests.running import oed

UR5 = example_robot("ur_description/urdf/ur5_robot.urdf")


def test_a_motion_for_the_load_alone_is_left_and_said_to_be(tmp_path, capsys):
    status = oed(
        "design", "--robot", "builtin:imi_scara", "--payload", "--horizon", "3", "--smoke",
        "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 0
    assert (tmp_path / "out" / "motion.csv").exists()
    record = json.loads((tmp_path / "out" / "design.json").read_text(encoding="utf-8"))
    assert any("parameters of a load at link_2" in note for note in record["notes"])
    said = capsys.readouterr().out
    assert "start the log a second before" in said
    (told,) = re.findall(r"the mass to ([\d.]+) kg \(half", said)
    (least,) = re.findall(r"better than ([\d.]+) kg", said)
    assert 0 < float(least) <= float(told)
    assert "rotor inertias are no part" not in said


def test_postures_are_left_where_no_motion_is_allowed(tmp_path):
    status = oed(
        "design", "--robot", UR5, "--payload", "--static", "--poses", "5", "--no-clearance",
        "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 0
    with (tmp_path / "out" / "poses.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 5
    # Turning about the vertical changes no weight.
    assert len({row["shoulder_pan_joint [rad]"] for row in rows}) == 1
    assert not (tmp_path / "out" / "motion.csv").exists()


STATIC = (
    "--robot",
    "builtin:imi_scara",
    "--gravity",
    "0",
    "-9.81",
    "0",
    "--payload",
    "--static",
    "--poses",
    "2",
)


def test_postures_that_nobody_checked_are_not_called_clear(tmp_path, capsys):
    assert oed("design", *STATIC, "--out", tmp_path / "out") == 0
    said = capsys.readouterr().out
    assert "2 postures, each within its limits\n" in said
    assert "not checked: clear of itself" in said
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "each within its limits." in page
    assert "Not checked: clear of itself" in page


def test_postures_leave_no_box_that_cannot_be_kept(tmp_path, capsys):
    """With or without shapes that may touch."""
    box = ("--box", "5", "6", "5", "6", "5", "6")
    for robot, why in ((), "has no geometry"), (("--robot", UR5, "--no-clearance"), "is clear"):
        assert oed("design", *STATIC, *robot, *box, "--out", tmp_path / "out") in {2, 3}
        said = capsys.readouterr().err
        assert why in said
        assert said.count("\n") == 1
        assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", [("--static",), ("--frame", "tool0"), ("--arm", "model.json")])
def test_what_means_nothing_without_payload_is_refused(option, tmp_path, capsys):
    status = oed("design", "--robot", "builtin:imi_scara", *option, "--out", tmp_path / "out")
    assert status == 2
    assert f"{option[0]}: only with --payload" in capsys.readouterr().err
