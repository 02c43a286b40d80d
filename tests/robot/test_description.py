"""Robot files that are none, or no tree: one line with the file's name and the link or joint."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oed.dynamics.cross_check import cross_check
from oed.errors import RobotError
from oed.robot import load_arm, load_robot
from tests.experiment.tiny_dataset import urdf_text

TAIL = """
  <joint name="tail" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <link name="end"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"""


def with_tail(folder: Path, kind: str, parent: str, child: str = "end") -> Path:
    """A chain of two joints and one more joint and link."""
    tail = TAIL.format(kind=kind, parent=parent, child=child)
    return written(folder, urdf_text(2).replace("</robot>", tail))


def written(folder: Path, content: str | bytes, name: str = "arm.urdf") -> Path:
    """A file of that content."""
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "this file is empty"),
        (b" \n ", "this file is empty"),
        (urdf_text(2)[:300].encode(), "it is truncated"),
        (urdf_text(2).replace("pendulum", "p\u00e9ndulo").encode("latin-1"), "byte 0xe9 in line 1"),
        (b"\x00\x01\x02\x7fELF", "cannot read this file as XML"),
        (b'<?xml version="1.0" encoding="klingon"?><robot/>', "cannot read this file as XML"),
        (b"<html><body>404</body></html>", "its outermost element is <html>"),
        (b'<robot name="r">' + b"<a>" * 5000 + b"</a>" * 5000 + b"</robot>", "more than 200 deep"),
        (b'<robot name="r"><link name="a"/></robot>', "no revolute or prismatic joint"),
        (b"<robot><link/></robot>", "a link has no name"),
        (urdf_text(2000).encode(), "describes 2001 links, more than 500"),
    ],
)
def test_a_file_that_is_no_robot(tmp_path: Path, content: bytes, why: str) -> None:
    refused(written(tmp_path, content), why)


def refused(path: Path, why: str) -> None:
    """Both ways in say the same, in one line that begins with the file's name."""
    for load in (load_robot, load_arm):
        with pytest.raises(RobotError, match=why) as caught:
            load(path)
        assert str(caught.value).startswith(str(path))
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "parent", "child", "why"),
    [
        (
            "revolute",
            "base",
            "link_2",
            "link 'link_2' is the child of two joints, 'joint_2' and 't",
        ),
        ("revolute", "link_2", "base", "carry each other in a circle"),
        ("fixed", "end", "end", "carry each other in a circle"),
        ("revolute", "nowhere", "end", "joint 'tail': its parent 'nowhere' is no link here"),
        ("hinge", "link_2", "end", "joint 'tail' is of type 'hinge'"),
        ("floating", "link_2", "end", "joint 'tail' is floating and hangs from joint 'joint_2'"),
        ("planar", "link_1", "end", "joint 'tail' is planar and hangs from joint 'joint_1'"),
    ],
)
def test_links_and_joints_that_are_no_tree(
    tmp_path: Path, kind: str, parent: str, child: str, why: str
) -> None:
    refused(with_tail(tmp_path, kind, parent, child), why)


@pytest.mark.parametrize("kind", ["joint", "link"])
def test_a_name_that_two_have(tmp_path: Path, kind: str) -> None:
    text = urdf_text(3).replace(f'<{kind} name="{kind}_3"', f'<{kind} name="{kind}_2"')
    refused(written(tmp_path, text), f"2 {kind}s are called '{kind}_2'")


def test_a_base_that_floats_is_fixed_and_told_of(tmp_path: Path) -> None:
    text = urdf_text(2).replace('link name="base"', 'link name="pelvis"').replace(
        'parent link="base"', 'parent link="pelvis"'
    )  # fmt: skip
    root = '<joint name="root" type="floating"><parent link="base"/><child link="pelvis"/></joint>'
    path = written(tmp_path, text.replace("</robot>", f'<link name="base"/>{root}</robot>'))
    robot = load_robot(path)
    assert robot.joint_names == ("joint_1", "joint_2")
    assert robot.notes == (
        ("joint 'root' is floating: taken as fixed, as an arm stands on its base",)
    )
    assert cross_check(robot, states=10).agrees


def test_a_link_that_nothing_carries_stands_on_the_base(tmp_path: Path) -> None:
    path = written(tmp_path, urdf_text(2).replace("</robot>", '<link name="table"/></robot>'))
    robot = load_robot(path)
    assert "links base, table have no parent" in robot.notes[0]
    assert cross_check(robot, states=10).agrees  # Pinocchio alone refuses such a file


def test_a_long_chain_loads(tmp_path: Path) -> None:
    assert load_arm(written(tmp_path, urdf_text(120))).n == 120


@pytest.mark.parametrize("name", ["arm.URDF", "arm.xml"])
def test_a_file_is_what_its_content_says(tmp_path: Path, name: str) -> None:
    robot = load_robot(written(tmp_path, urdf_text(2), name))
    assert robot.joint_names == ("joint_1", "joint_2")
    assert cross_check(robot, states=10).pinocchio is not None


def test_a_text_in_another_encoding_is_read_as_it_says(tmp_path: Path) -> None:
    text = '<?xml version="1.0" encoding="UTF-16"?>' + urdf_text(2).replace("base", "b\u00e4se")
    robot = load_robot(written(tmp_path, text.encode("utf-16")))
    assert cross_check(robot, states=10).agrees


def test_a_closed_loop_of_sdf_is_named(tmp_path: Path) -> None:
    joint = (
        '<joint name="{0}" type="revolute"><parent>{1}</parent><child>{2}</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint>"
    )
    joints = [joint.format(*names) for names in (("j", "a", "b"), ("k", "b", "c"), ("l", "a", "c"))]
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    text = f'<sdf version="1.9"><model name="m">{links}{"".join(joints)}</model></sdf>'
    refused(written(tmp_path, text, "arm.sdf"), "its joints form a closed loop")


def test_a_ball_joint_inside_a_chain_is_refused(tmp_path: Path) -> None:
    body = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    inner = f'<body name="b" pos="1 0 0"><joint name="socket" type="ball"/>{body}</body>'
    text = f'<mujoco><worldbody><body name="a"><joint name="j"/>{body}{inner}</body></worldbody></mujoco>'
    refused(written(tmp_path, text, "arm.xml"), "joint 'socket' is .* and hangs from a joint that")


def test_a_device_is_no_robot() -> None:
    with pytest.raises(RobotError, match="/dev/zero: is a device, not a file"):
        load_robot("/dev/zero")


def test_a_number_of_an_sdf_inertia_is_checked_too(tmp_path: Path) -> None:
    text = (
        '<sdf version="1.9"><model name="m"><link name="base"/><link name="arm"><inertial>'
        "<mass>2</mass><inertia><ixx>9</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>"
        '<joint name="j" type="revolute"><parent>base</parent><child>arm</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"
    )
    robot = load_robot(written(tmp_path, text, "arm.sdf"))
    assert "link 'arm': no body has principal moments of inertia 1, 1, 9" in robot.notes[0]
    ball = 0.4 * 2 * np.cbrt(3 * 2 / (4 * np.pi * 1000)) ** 2
    assert robot.parameters[[4, 7, 9]] == pytest.approx(ball)
