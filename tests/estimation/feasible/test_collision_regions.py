import numpy as np
import pytest

from oed.dynamics.models import build_model
from oed.errors import RobotError
from oed.estimation.feasible.collision_regions import collision_regions
from oed.estimation.feasible.feasible_set import FeasibleSet, inequality_rows
from oed.robot import load_robot
from tests.estimation.feasible.cases import small_model
from tests.paths import example_robot

BOXES = """<robot name="boxes">
  <link name="base"/>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/>
  </joint>
  <link name="arm">
    <inertial><mass value="1"/><origin xyz="0.2 0 0"/>
      <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.2"/></geometry></collision>
  </link>
  <joint name="weld" type="fixed">
    <parent link="arm"/><child link="tip"/><origin xyz="0.5 0 0" rpy="0 0 1.5707963267948966"/>
  </joint>
  <link name="tip">
    <collision><geometry><box size="0.6 0.2 0.1"/></geometry></collision>
  </link>
</robot>
"""


def test_a_box_holds_all_shapes_that_a_joint_carries(tmp_path):
    path = tmp_path / "boxes.urdf"
    path.write_text(BOXES, encoding="utf-8")
    robot = load_robot(path)
    (region,) = collision_regions(robot, clearance=0.0)
    # x from 0 to 0.6, y +-0.3 (the turned tip), z +-0.1: corners are on the bound, no further.
    for corner, inside in (
        ((0.0, -0.3, -0.1), 0.0),
        ((0.6, 0.3, 0.1), 0.0),
        ((0.61, 0.0, 0.0), -1.0),
        ((0.3, 0.31, 0.0), -1.0),
        ((0.3, 0.0, 0.0), 1.0),
    ):
        point = np.append(corner, 1.0)
        values = np.einsum("kij,i,j->k", region.matrices, point, point)
        assert np.sign(np.round(values.min(), 9)) == inside


def test_a_held_joint_carries_its_shapes_where_it_is_held(tmp_path):
    welded, held = tmp_path / "welded.urdf", tmp_path / "held.urdf"
    welded.write_text(BOXES, encoding="utf-8")
    hinge = '<axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
    text = BOXES.replace('name="weld" type="fixed"', 'name="weld" type="revolute"')
    text = text.replace(' rpy="0 0 1.5707963267948966"/>\n  </joint>', "/>" + hinge)
    held.write_text(text, encoding="utf-8")
    robots = load_robot(welded), load_robot(held, joints=["turn"], locked={"weld": np.pi / 2})
    (expected,), (found,) = (collision_regions(robot) for robot in robots)
    assert np.allclose(found.matrices, expected.matrices, rtol=0, atol=1e-9)


def test_the_makers_bodies_lie_inside_their_meshes():
    robot = load_robot(example_robot("kinova_description/robots/kinova.urdf"))
    model = build_model("standard", robot)
    regions = collision_regions(robot, clearance=0.03)
    assert {region.link for region in regions} == set(range(6))
    rows = inequality_rows(FeasibleSet(regions=regions), model)
    assert np.all(rows.matrix[:, :60] @ robot.parameters >= 0)


def test_refuses_a_robot_without_a_file():
    with pytest.raises(RobotError, match="does not come from a file"):
        collision_regions(small_model().robot)
