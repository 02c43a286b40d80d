"""Xacro is read by its name or its content, and bounded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oed.dynamics.cross_check import cross_check
from oed.errors import RobotError
from oed.robot import load_robot, xacro_file
from tests.experiment.tiny_dataset import urdf_text

HEAD = '<robot name="pendulum" xmlns:xacro="http://www.ros.org/wiki/xacro">'
LENGTH = '<xacro:arg name="length" default="0.3"/><xacro:property name="l" value="$(arg length)"/>'


def written(folder: Path, name: str, defined: str = LENGTH, value: str = "${l}") -> Path:
    """The chain of two joints, its links as long as an argument says."""
    text = urdf_text(2).replace('<robot name="pendulum">', HEAD + defined)
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text.replace('xyz="0.3 0 0"', f'xyz="{value} 0 0"'))
    return path


@pytest.mark.parametrize("name", ["arm.urdf.xacro", "arm.xacro", "arm.urdf"])
def test_xacro_is_known_by_its_name_or_its_content(tmp_path: Path, name: str) -> None:
    (tmp_path / "plain.urdf").write_text(urdf_text(2))
    plain = load_robot(tmp_path / "plain.urdf")
    robot = load_robot(written(tmp_path, name))
    assert np.array_equal(robot.parameters, plain.parameters)
    assert np.array_equal(robot.joints[1].p_PJ, plain.joints[1].p_PJ)
    assert cross_check(robot, states=10).agrees


def test_arguments_follow_the_name(tmp_path: Path) -> None:
    robot = load_robot(f"{written(tmp_path, 'arm.urdf.xacro')} length:=0.7")
    assert robot.joints[1].p_PJ == pytest.approx([0.7, 0, 0])


def test_a_urdf_that_xacro_wrote_is_no_xacro(tmp_path: Path) -> None:
    path = written(tmp_path, "arm.urdf", defined="", value="0.3")
    assert load_robot(path).joint_names == ("joint_1", "joint_2")


def test_packages_are_found_among_the_folders_above(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "package.xml").write_text("<package><name>my_parts</name></package>")
    (tmp_path / "parts" / "sizes.xacro").write_text(
        f'{HEAD}<xacro:property name="l" value="0.4"/></robot>'
    )
    include = '<xacro:include filename="$(find my_parts)/sizes.xacro"/>'
    path = written(tmp_path, "parts/urdf/arm.urdf.xacro", include)
    assert load_robot(path).joints[1].p_PJ == pytest.approx([0.4, 0, 0])


@pytest.mark.parametrize(
    ("defined", "value", "why"),
    [
        ("", "${l}", "name 'l' is not defined"),
        (
            '<xacro:include filename="$(find nowhere)/a.xacro"/>',
            "1",
            "package 'nowhere' is neither",
        ),
        ('<xacro:include filename="absent.xacro"/>', "1", "absent.xacro"),
        ("<xacro:absent/>", "1", "absent"),
        ("", "${'x' * 10**10}", "it takes more than 2 GB"),
    ],
)
def test_what_cannot_be_expanded_is_one_line(
    tmp_path: Path, defined: str, value: str, why: str
) -> None:
    path = written(tmp_path, "arm.urdf", defined, value)
    with pytest.raises(RobotError, match=why) as caught:
        load_robot(path)
    assert str(caught.value).startswith(f"{path}: this is xacro, which cannot be expanded: ")
    assert "\n" not in str(caught.value)


def test_an_expression_without_an_end_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(xacro_file, "SECONDS", 2)
    path = written(tmp_path, "arm.xacro", "", "${sum(i for i in range(10**15))}")
    with pytest.raises(RobotError, match=r"arm\.xacro: this is xacro"):
        load_robot(path)
