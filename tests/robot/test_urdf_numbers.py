"""Text where a URDF must hold numbers is named, since Drake would make zeros of it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from oed.errors import RobotError
from oed.robot import load_robot
from tests.experiment.tiny_dataset import refused, urdf_text, with_urdf

ORIGIN = 'xyz="0.3 0 0"'


def arm(folder: Path, old: str, new: str) -> Path:
    """A planar chain with `old` replaced where it occurs first."""
    text = urdf_text(2)
    assert old in text
    path = folder / "arm.urdf"
    path.write_text(text.replace(old, new, 1))
    return path


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        (ORIGIN, 'xyz="0,3 0 0"', "xyz='0,3 0 0' of <origin> is not 3 numbers; write numbers with"),
        (ORIGIN, 'xyz="0.3,0,0"', "xyz='0.3,0,0' of <origin> is not 3 numbers; write numbers with"),
        (ORIGIN, 'xyz="0.3 0"', "xyz='0.3 0' of <origin> is not 3 numbers"),
        (ORIGIN, 'xyz="nan 0 0"', "xyz='nan 0 0' of <origin> is not 3 numbers"),
        ('upper="3"', 'upper="inf"', "upper='inf' of <limit> is not a number"),
        ('velocity="4"', 'velocity="2,2"', "velocity='2,2' of <limit> is not a number"),
        ('axis xyz="0 0 1"', 'axis xyz="z"', "xyz='z' of <axis> is not 3 numbers"),
    ],
)
def test_text_for_a_number_of_a_joint(tmp_path: Path, old: str, new: str, why: str) -> None:
    with pytest.raises(RobotError, match=rf"arm\.urdf: joint 'joint_1': .*{re.escape(why)}"):
        load_robot(arm(tmp_path, old, new))


def test_text_for_a_number_of_an_inertia(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="link 'link_1': value='0,6' of <mass> is not a number"):
        load_robot(arm(tmp_path, '<mass value="1"/>', '<mass value="0,6"/>'))


def test_numbers_of_any_form_are_read(tmp_path: Path) -> None:
    path = arm(tmp_path, ORIGIN, 'xyz=" 3e-1\t+.0\n -0. "')
    assert np.allclose(load_robot(path).joints[0].p_PJ, [0.3, 0, 0])


def test_a_data_set_names_its_robot_file(tmp_path: Path) -> None:
    folder = with_urdf(tmp_path, 2)
    file = folder / "robot.urdf"
    file.write_text(file.read_text().replace(ORIGIN, 'xyz="0,3 0 0"'))
    error = refused(folder)
    assert error.column == "robot"
    assert "robot.urdf: joint 'joint_1': xyz='0,3 0 0'" in str(error)
