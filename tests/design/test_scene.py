"""A robot's shapes as Drake holds them: what cannot be read is said, and costs nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oed.design.collision import Surroundings
from oed.design.default_limits import with_default_limits
from oed.robot import load_robot
from tests.design.primitive_arm import LENGTH, TIP, planar_arm, sphere, tip_at
from tests.paths import example_robot

PAIR = ("base", "lower")


def test_missing_meshes_are_said_and_the_rest_is_checked(tmp_path: Path) -> None:
    absent = '<collision><geometry><mesh filename="package://gone/a.stl"/></geometry></collision>'
    robot = planar_arm(
        tmp_path, base=sphere(0.1, "0 0.9 0"), upper=absent, lower=sphere(TIP, f"{LENGTH} 0 0")
    )
    surroundings = Surroundings(robot)
    assert "package://gone/a.stl" in surroundings.note
    assert surroundings.missing == ("package://gone/a.stl",)
    q = np.array([1.5, 0.1])
    assert surroundings.distances(q)[PAIR] == pytest.approx(
        np.linalg.norm(tip_at(q) - [0, 0.9, 0]) - 0.1 - TIP, abs=1e-9
    )


def test_a_file_that_has_changed_is_read_again(tmp_path: Path) -> None:
    before = Surroundings(planar_arm(tmp_path, base=sphere(0.2), lower=sphere(0.2)))
    after = Surroundings(planar_arm(tmp_path, base=sphere(0.1), lower=sphere(0.2)))
    assert before.distances(np.zeros(2))[PAIR] == pytest.approx(0.1)
    assert after.distances(np.zeros(2))[PAIR] == pytest.approx(0.2)


def test_an_mjcf_file_has_its_shapes_too(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text("""<mujoco model="arm"><worldbody>
<geom name="post" type="sphere" size="0.1" pos="0 0.9 0"/>
<body name="upper"><joint name="shoulder" axis="0 0 1" range="-170 170"/>
<geom type="sphere" size="0.1" pos="0.5 0 0"/></body>
</worldbody></mujoco>""")
    robot = load_robot(tmp_path / "arm.xml")
    found = Surroundings(robot).distances(np.array([1.2]))
    at = 0.5 * np.array([np.cos(1.2), np.sin(1.2)])
    (distance,) = found.values()
    assert distance == pytest.approx(np.linalg.norm(at - [0, 0.9]) - 0.2, abs=1e-9)


def test_a_floor_is_checked_where_drake_can_and_else_said(tmp_path: Path) -> None:
    def distances(shape: str) -> tuple[dict, str]:
        (tmp_path / "arm.xml").write_text(f"""<mujoco model="arm"><worldbody>
<geom type="plane" size="1 1 0.1"/>
<body name="arm"><joint name="j" axis="0 1 0" range="-90 90"/>
<geom {shape} pos="0.5 0 0.1"/></body></worldbody></mujoco>""")
        surroundings = Surroundings(load_robot(tmp_path / "arm.xml"))
        return surroundings.distances(np.array([-0.5])), surroundings.note

    found, note = distances('type="sphere" size="0.05"')
    assert note == ""
    # Turned upwards by half a radian about y.
    height = 0.5 * np.sin(0.5) + 0.1 * np.cos(0.5)
    assert found == {("arm", "world"): pytest.approx(height - 0.05)}
    _, note = distances('type="box" size="0.05 0.05 0.05"')
    assert "planes" in note


@pytest.mark.parametrize(
    "colour", ['<color rgba="1 0 0"/>', '<texture filename="gone.png"/>'], ids=["rgb", "texture"]
)
def test_a_colour_that_drake_refuses_costs_the_drawing_only(colour: str, tmp_path: Path) -> None:
    painted = sphere(0.1, kind="visual").replace(
        "</visual>", f'<material name="m">{colour}</material></visual>'
    )
    robot = planar_arm(
        tmp_path, base=sphere(0.1, "0 0.9 0") + painted, lower=sphere(TIP, f"{LENGTH} 0 0")
    )
    surroundings, q = Surroundings(robot), np.array([1.5, 0.1])
    assert "drawings" in surroundings.note
    distance = np.linalg.norm(tip_at(q) - [0, 0.9, 0]) - 0.1 - TIP
    assert surroundings.distances(q)[PAIR] == pytest.approx(distance, abs=1e-9)


def test_shapes_that_drake_refuses_are_said(tmp_path: Path) -> None:
    (tmp_path / "bad.obj").write_text("v a b c\n")
    bad = '<collision><geometry><mesh filename="bad.obj"/></geometry></collision>'
    surroundings = Surroundings(planar_arm(tmp_path, lower=bad))
    assert not surroundings.has_shapes
    assert "shapes cannot be read" in surroundings.note


def test_an_arm_of_meshes_is_found_whole_and_its_slopes_are_finite_differences() -> None:
    robot, _ = with_default_limits(load_robot(example_robot("ur_description/urdf/ur5_robot.urdf")))
    surroundings = Surroundings(robot)
    assert "cannot be" not in surroundings.note
    rng, step, errors = np.random.default_rng(5), 1e-4, []
    lower, upper = robot.limits.position.T
    for q in rng.uniform(lower, upper, (10, robot.n)):
        ends = [
            [surroundings.distances(q + sign * d) for sign in (1, -1)]
            for d in step * np.eye(robot.n)
        ]
        for near in surroundings.near(q):
            if near.distance > 0.01 and all(near.pair in end for pair in ends for end in pair):
                numeric = [(up[near.pair] - down[near.pair]) / 2 / step for up, down in ends]
                errors.append(np.abs(near.slope - numeric).max())
    assert len(errors) > 40
    # Not all: Drake's distance of two hulls is now and then a tenth of a millimetre off.
    assert np.quantile(errors, 0.9) < 1e-5
