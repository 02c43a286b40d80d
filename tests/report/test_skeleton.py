"""An arm without shapes is drawn where its joints are."""

from pathlib import Path

import numpy as np
from pydrake.geometry import Box

from oed.report.skeleton import body_poses, skeleton
from oed.robot import imi_scara, load_robot
from tests.design.primitive_arm import elbow_at, planar_arm


def ends(part) -> np.ndarray:
    """Both ends of a part along its own axis, in the body's frame [m]."""
    return part.place.multiply(np.array([[0, 0, s * part.size[2]] for s in (-1.0, 1.0)]).T).T


def test_bodies_are_where_the_kinematics_has_them(tmp_path: Path) -> None:
    q = np.array([0.4, -1.1])
    poses = body_poses(planar_arm(tmp_path), q)
    np.testing.assert_allclose(poses[1].translation(), elbow_at(q), atol=1e-12)
    angle = q.sum()
    expected = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    np.testing.assert_allclose(poses[1].rotation().matrix(), expected, atol=1e-12)


def test_lines_lead_from_joint_to_joint_and_to_the_last_centre_of_mass() -> None:
    upper, lower = (part for part in skeleton(imi_scara()) if part.size[2] > 0.05)
    np.testing.assert_allclose(ends(upper), [[0, 0, 0], [0.359, 0, 0]], atol=1e-12)
    # Of 6 kg, with first moments 0.808 and 0.328 kg m: the paper's own.
    np.testing.assert_allclose(ends(lower), [[0, 0, 0], [0.808 / 6, 0.328 / 6, 0]], atol=1e-12)


def test_what_slides_hangs_on_a_rail_as_long_as_its_range(tmp_path: Path) -> None:
    path = tmp_path / "slide.urdf"
    path.write_text(
        """<robot name="slide"><link name="base"/><link name="cart"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-0.2" upper="0.7" velocity="1" effort="9"/></joint></robot>""",
        encoding="utf-8",
    )
    rail, cart = skeleton(load_robot(path))
    assert rail.body == -1
    np.testing.assert_allclose(ends(rail), [[-0.2, 0, 0], [0.7, 0, 0]], atol=1e-12)
    assert isinstance(cart.shape, Box)
    assert cart.body == 0
