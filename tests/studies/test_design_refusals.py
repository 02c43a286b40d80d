"""What cannot be designed is refused in one line, and nothing is left behind."""

import json
from pathlib import Path

import pytest

from tests.design.primitive_arm import arm_and_post, planar_arm
from tests.experiment.tiny_dataset import urdf_text
from tests.running import oed


def test_a_box_out_of_reach_is_no_usable_result(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arm_and_post(tmp_path)
    robot = ("--robot", str(tmp_path / "planar.urdf"))
    walls = ("--box", "5", "6", "5", "6", "5", "6")
    assert "check the box" in refused(capfd, tmp_path / "out", *robot, *walls, code=3)


def refused(capfd: pytest.CaptureFixture[str], out: Path, *wishes: str, code: int = 2) -> str:
    """The one line on a wish that cannot be met; nothing is left behind."""
    assert oed("design", *wishes, "--out", str(out)) == code
    printed = capfd.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert printed.err.startswith("oed design: ")
    assert not out.exists()
    return printed.err


@pytest.mark.parametrize("robot", ["absent.urdf", "builtin:puma"])
def test_a_robot_that_is_not_there_is_one_line(
    robot: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert robot.removeprefix("builtin:") in refused(capfd, tmp_path / "out", "--robot", robot)


@pytest.mark.parametrize(
    ("wish", "named"),
    [
        (("--horizon", "-3"), "--horizon -3"),
        (("--horizon", "inf"), "--horizon inf"),
        (("--rate", "0"), "--rate 0"),
        (("--rate", "nan"), "--rate nan"),
        (("--rate", "1e5"), "set points"),
        (("--rate", "1"), "fewer than 50 set points"),
        (("--scale", "1e-3"), "at --scale 0.001 is more than 200000 set points"),
        (("--budget", "inf"), "--budget inf"),
        (("--seed", "-1"), "--seed: -1 "),
        (("--margin", "1.1"), "--margin 1.1"),
        (("--margin", "0"), "--margin 0"),
        (("--scale", "2"), "--scale 2"),
        (("--clearance", "-1"), "--clearance -1"),
        (("--clearance", "0.01", "--avoid-collision", "--no-clearance"), "contradict"),
        (("--gravity", "0", "nan", "0"), "--gravity"),
        (("--package", "arm"), "NAME=DIR"),
        (("--box", "0", "1", "1", "1", "0", "1"), "--box"),
        (("--box", "0", "1", "0", "nan", "0", "1"), "--box"),
        (("--joints", "wrist"), "wrist"),
        (("--joints", "elbow", "elbow"), "named twice"),
        (("--prior", "nowhere/design.json"), "nowhere/design.json"),
        (("--evaluations", "0"), "--evaluations: 0 "),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)
def test_a_wish_that_cannot_be_met_is_one_line(
    wish: tuple[str, ...], named: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arm_and_post(tmp_path)
    robot = str(tmp_path / "planar.urdf")
    assert named in refused(capfd, tmp_path / "out", "--robot", robot, *wish)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no XML",
        '<robot name="r"><link name="a">',
        "<html/>",
        '<robot name="r"><link name="a"/></robot>',
    ],
    ids=["empty", "text", "half", "html", "no_joint"],
)
def test_a_file_that_is_no_arm_is_one_line(
    text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "r.urdf").write_text(text)
    assert "r.urdf" in refused(capfd, tmp_path / "out", "--robot", str(tmp_path / "r.urdf"))


def test_collisions_cannot_be_avoided_without_shapes(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    planar_arm(tmp_path)
    for robot in ("builtin:imi_scara", str(tmp_path / "planar.urdf")):
        message = refused(capfd, tmp_path / "out", "--robot", robot, "--avoid-collision")
        assert "--avoid-collision" in message


def test_another_arms_experiment_is_no_prior(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    planar_arm(tmp_path)
    record = {"joints": ["a"], "class": "fourier", "instants": 9, "horizon": 1, "coefficients": {}}
    (tmp_path / "a.json").write_text(json.dumps(record))
    message = refused(
        capfd, tmp_path / "out", "--robot", str(tmp_path / "planar.urdf"),
        "--prior", str(tmp_path / "a.json"),
    )  # fmt: skip
    assert "a.json" in message
    assert "shoulder" in message


def test_results_are_not_put_where_a_file_is(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").write_text("mine")
    assert oed("design", "--robot", "builtin:imi_scara", "--out", str(tmp_path / "out")) == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert (tmp_path / "out").read_text() == "mine"


def test_a_mass_that_cannot_be_is_refused_where_torque_is_limited_by_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(urdf_text(2).replace('mass value="1"', 'mass value="-1"', 1))
    out = tmp_path / "out"
    arguments = ["--robot", str(file), "--out", str(out), "--smoke"]
    assert oed("design", *arguments) == 2
    message = capsys.readouterr().err
    assert "link 'link_1' has a mass of -1 kg" in message
    assert message.count("\n") == 1
    assert not out.exists()
    assert oed("design", *arguments, "--no-torque") == 0
