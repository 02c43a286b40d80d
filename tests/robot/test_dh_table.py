"""Tables of Denavit-Hartenberg parameters against the product of their matrices."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from oed.dynamics.cross_check import cross_check
from oed.errors import RobotError
from oed.robot import Robot, load_robot
from oed.robot.robot_file import load_plant

# a, alpha, d, theta, kind; a SCARA's slide, a tilted axis and offsets of every kind.
ROWS = (
    (0.1, np.pi / 2, 0.3, 0.2, "revolute"),
    (0.4, -0.3, 0.05, -np.pi / 2, "revolute"),
    (0.02, np.pi / 2, 0.1, 0.7, "prismatic"),
    (0.0, -np.pi / 2, 0.25, 0.0, "revolute"),
)
COM = np.array([0.03, -0.02, 0.05])


def table(convention: str, *, degrees: bool = False) -> str:
    """The rows as a file, every link with a mass."""
    turn = 180 / np.pi if degrees else 1.0
    rows = [f'convention = "{convention}"', f'angles = "{"deg" if degrees else "rad"}"']
    for a, alpha, d, theta, kind in ROWS:
        bound = 0.5 if kind == "prismatic" else 2 * turn
        rows += [
            "[[joint]]",
            f"a = {a!r}\nalpha = {alpha * turn!r}\nd = {d!r}\ntheta = {theta * turn!r}",
            f'kind = "{kind}"\nlower = {-bound!r}\nupper = {bound!r}\nvelocity = {bound!r}',
            f"effort = 9.0\nmass = 2.0\ncom = {COM.tolist()}",
            "inertia = [0.02, 0.001, 0.002, 0.03, 0.003, 0.04]",
        ]
    return "\n".join(rows) + "\n"


def frames(convention: str, q: np.ndarray) -> list[np.ndarray]:
    """Poses of the rows' frames in the base, multiplied out as the textbooks write them."""
    poses, pose = [], np.eye(4)
    for (a, alpha, d, theta, kind), x in zip(ROWS, q, strict=True):
        d, theta = (d + x, theta) if kind == "prismatic" else (d, theta + x)  # noqa: PLW2901
        ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        if convention == "standard":
            step = [
                [ct, -st * ca, st * sa, a * ct],
                [st, ct * ca, -ct * sa, a * st],
                [0, sa, ca, d],
                [0, 0, 0, 1],
            ]
        else:
            step = [
                [ct, -st, 0, a],
                [st * ca, ct * ca, -sa, -sa * d],
                [st * sa, ct * sa, ca, ca * d],
                [0, 0, 0, 1],
            ]
        pose = pose @ np.array(step)
        poses.append(pose)
    return poses


def written(folder: Path, text: str) -> Path:
    path = folder / "dh.toml"
    path.write_text(text)
    return path


def centres(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Of mass of the links, by Drake, in the base [m]."""
    assert robot.description is not None
    plant = load_plant(robot.description)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
    bodies = [plant.GetBodyByName(f"link_{i + 1}") for i in range(len(q))]
    return np.array(
        [
            plant.EvalBodyPoseInWorld(context, b) @ b.CalcCenterOfMassInBodyFrame(context)
            for b in bodies
        ]
    )


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("degrees", [False, True])
def test_links_are_where_the_matrices_put_them(
    tmp_path: Path, convention: str, degrees: bool
) -> None:
    robot = load_robot(written(tmp_path, table(convention, degrees=degrees)))
    assert [joint.kind for joint in robot.joints] == [row[4] for row in ROWS]
    for q in np.random.default_rng(0).uniform(-0.5, 0.5, (5, 4)):
        expected = [(pose @ [*COM, 1.0])[:3] for pose in frames(convention, q)]
        assert centres(robot, q) == pytest.approx(np.array(expected), abs=1e-12)
    assert cross_check(robot, states=20).agrees


def test_potential_energy_is_that_of_the_frames(tmp_path: Path) -> None:
    """The gravity torque is the slope of the energy of the textbook's frames."""
    robot = load_robot(written(tmp_path, table("standard")))
    assert robot.description is not None
    model = pinocchio.buildModelFromXML(robot.description.text)
    q = np.array([0.3, -0.4, 0.1, 0.2])
    torque = pinocchio.computeGeneralizedGravity(model, model.createData(), q)

    def energy(q: np.ndarray) -> float:
        return sum(2.0 * 9.81 * (pose @ [*COM, 1.0])[2] for pose in frames("standard", q))

    step = 1e-6 * np.eye(4)
    slope = [(energy(q + h) - energy(q - h)) / 2e-6 for h in step]
    assert torque == pytest.approx(np.array(slope), abs=1e-6)


def test_limits_are_in_the_units_of_the_table(tmp_path: Path) -> None:
    limits = load_robot(written(tmp_path, table("modified", degrees=True))).limits
    assert limits.position == pytest.approx(np.array([[-2, 2], [-2, 2], [-0.5, 0.5], [-2, 2]]))
    assert limits.velocity[:, 1] == pytest.approx([2, 2, 0.5, 2])
    assert limits.torque[:, 1] == pytest.approx(9.0)


def test_what_is_not_given_is_not_limited_and_has_no_mass(tmp_path: Path) -> None:
    text = 'convention = "standard"\n[[joint]]\na = 0.1\nalpha = 0.0\n[[joint]]\na = 0.2\nalpha = 0.0\n'
    robot = load_robot(written(tmp_path, text))
    assert robot.joint_names == ("joint_1", "joint_2")
    assert not np.isfinite(robot.limits.position).any()
    assert not np.isfinite(robot.limits.torque).any()
    assert not robot.parameters.any()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "convention"),
        ('convention = "craig"\njoint = []', "craig"),
        ('convention = "standard"\njoint = []', "no .*joint.* table"),
        ('convention = "standard"\n[[joint]]\na = 0.1', "alpha"),
        (
            'convention = "standard"\n[[joint]]\na = "0.1"\nalpha = 0',
            r"joint\[0\]\.a|joint\[...\]\.a",
        ),
        ('convention = "standard"\n[[joint]]\na = 1\nalpha = 0\ntwist = 2', "twist"),
        ('convention = "standard"\n[[joint]]\na = nan\nalpha = 0', "not finite"),
        ('convention = "standard"\n[[joint]]\na = 1\nalpha = 0\nlower = -1', "both of lower and"),
        ("a = " + "[" * 100_000, "dh.toml"),
    ],
)
def test_a_table_that_is_none_is_one_line(tmp_path: Path, text: str, why: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(RobotError, match=why) as caught:
        load_robot(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
