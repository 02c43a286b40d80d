"""What is printed of a design claims no more than was checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oed.design.clearance import check_clearance
from oed.design.collision import Surroundings
from oed.dynamics.motion import Motion
from studies.design_summary import _clearance_line
from tests.design.primitive_arm import planar_arm, sphere

ABSENT = '<collision><geometry><mesh filename="package://gone/a.stl"/></geometry></collision>'
STILL = Motion(np.zeros(1), *np.zeros((3, 1, 2)))


@pytest.mark.parametrize(("base", "told"), [(sphere(0.05), "of the others"), ("", "not checked")])
def test_a_missing_mesh_leaves_the_clearance_unchecked(
    base: str, told: str, tmp_path: Path
) -> None:
    robot = planar_arm(tmp_path, base=base, upper=ABSENT, lower=sphere(0.05, "-0.3 0 0"))
    check = check_clearance(Surroundings(robot), STILL)
    assert check.missing_shapes == 1
    assert not check.is_clear
    line = _clearance_line(check)
    assert line.startswith("not checked for want of the meshes of 1 collision shapes")
    assert told in line
    assert "nothing comes near" not in line


def test_with_every_shape_there_nothing_comes_near(tmp_path: Path) -> None:
    robot = planar_arm(tmp_path, base=sphere(0.05), lower=sphere(0.05, "0.3 0 0"))
    check = check_clearance(Surroundings(robot), STILL)
    assert check.is_clear
    assert _clearance_line(check).startswith("nothing comes near")
