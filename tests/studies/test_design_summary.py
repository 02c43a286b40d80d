"""What is printed of a design claims no more than was proven."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oed.design.clearance import ClearanceCheck, clearance_status, prove_clearance
from oed.design.collision import Surroundings
from oed.design.status import DesignStatus
from oed.design.trajectories import FourierClass
from oed.report.design_summary import clearance_line
from oed.robot import Robot
from tests.design.primitive_arm import planar_arm, sphere

ABSENT = '<collision><geometry><mesh filename="package://gone/a.stl"/></geometry></collision>'


def still(robot: Robot) -> ClearanceCheck:
    trajectory = FourierClass(1.0, robot.limits, harmonics=1)
    return prove_clearance(Surroundings(robot), trajectory, np.zeros(trajectory.size))


@pytest.mark.parametrize("base", [sphere(0.05), ""])
def test_a_missing_mesh_leaves_the_clearance_unchecked(base: str, tmp_path: Path) -> None:
    check = still(planar_arm(tmp_path, base=base, upper=ABSENT, lower=sphere(0.05, "-0.3 0 0")))
    assert check.missing == ("package://gone/a.stl",)
    assert "package://gone/a.stl" in clearance_line(check)
    (status,) = clearance_status(check, is_wanted=True, is_asked=False, has_box=False)
    assert status.standing == "not checked"
    assert "package://gone/a.stl" in status.evidence
    assert "--package" in status.evidence
    assert not status.is_open
    (asked,) = clearance_status(check, is_wanted=True, is_asked=True, has_box=False)
    assert asked.is_open


def test_with_every_shape_there_nothing_comes_near(tmp_path: Path) -> None:
    check = still(planar_arm(tmp_path, base=sphere(0.05), lower=sphere(0.05, "0.3 0 0")))
    assert clearance_line(check).startswith("nothing comes near")
    (status,) = clearance_status(check, is_wanted=True, is_asked=True, has_box=False)
    assert (status.standing, status.evidence) == ("proven", "by 10 mm")


@pytest.mark.parametrize(
    ("shapes", "told"),
    [
        # Spheres about base and elbow reach each other at any angle; the post is a stranger.
        (
            {"base": sphere(0.3) + sphere(0.1, "0 0.9 0"), "lower": sphere(0.3)},
            "base and lower overlap in nearly all postures",
        ),
        (
            {"base": sphere(0.05), "upper": sphere(0.1, kind="visual"), "lower": sphere(0.05)},
            "upper drawn without a collision shape",
        ),
    ],
)
def test_what_cannot_be_judged_is_in_the_status_and_not_called_clear(
    shapes: dict[str, Any], told: str, tmp_path: Path
) -> None:
    check = still(planar_arm(tmp_path, **shapes))
    assert check.is_kept
    (status,) = clearance_status(check, is_wanted=True, is_asked=False, has_box=False)
    assert status.standing == "not checked"
    assert status.evidence == f"{told}; all else keeps 10 mm"
    (asked,) = clearance_status(check, is_wanted=True, is_asked=True, has_box=False)
    assert asked.is_open


def test_links_that_are_close_by_design_are_told_with_what_they_keep(tmp_path: Path) -> None:
    # Base and elbow are 1.2 cm apart at any angle.
    check = still(planar_arm(tmp_path, base=sphere(0.238), lower=sphere(0.25)))
    (status,) = clearance_status(check, is_wanted=True, is_asked=True, has_box=False)
    assert status.standing == "proven"
    assert status.evidence == "by 10 mm (base and lower 6.0 mm, too close by design)"
    assert "clear of itself: by 10 mm (base and lower 6.0 mm" in str(DesignStatus((status,)))


def test_an_overlap_is_not_kept_or_given_up(tmp_path: Path) -> None:
    check = still(planar_arm(tmp_path, base=sphere(0.3, "0.9 0 0"), lower=sphere(0.1, "0.5 0 0")))
    assert "base and lower overlap by" in clearance_line(check)
    (status,) = clearance_status(check, is_wanted=True, is_asked=False, has_box=False)
    assert status.standing == "not kept"
    assert status.is_open
    (given_up,) = clearance_status(check, is_wanted=False, is_asked=False, has_box=False)
    assert given_up.standing == "given up"
