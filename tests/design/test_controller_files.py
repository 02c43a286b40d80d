"""What a controller reads is what was designed, and only an arm that can take a file gets it."""

import dataclasses
import re

import numpy as np
import pytest

from oed.design.controller_files import (
    GAIN,
    LOOKAHEAD,
    NEAR,
    files_for,
    write_libfranka_csv,
    write_urscript,
)
from oed.design.export import SetPoints
from oed.dynamics.motion import Motion
from oed.robot import imi_scara, load_arm
from tests.paths import example_robot

UR5 = example_robot("ur_description/urdf/ur5_robot.urdf")


def points(joints, t):
    """Set points that no two joints share, negative ones and small ones among them."""
    q = np.random.default_rng(0).normal(size=(len(t), joints)) * np.logspace(0, -6, joints)
    zeros = np.zeros_like(q)
    return SetPoints(tuple(f"j{k}" for k in range(joints)), Motion(t, q, zeros, zeros))


def numbers(text):
    return [float(x) for x in text.split(",")]


def run_urscript(text):
    """Time and joints of a program's set points, and those that it starts at, as its manual has it."""
    lines = [line.strip() for line in text.splitlines() if not line.startswith("#")]
    assert lines[0] == "def oed_motion():"
    assert lines[-1] == "end"
    # Every block is closed.
    opened = [x for x in lines if x.endswith(":")]
    assert len(opened) == lines.count("end")
    (start,) = (numbers(x[9:-1]) for x in lines if x.startswith("start = ["))
    t, q = [0.0], [start]
    for line in lines:
        command = re.fullmatch(r"servoj\(\[(.*)\], 0, 0, (.*)\)", line)
        if command:
            step, lookahead, gain = numbers(command[2])
            assert (lookahead, gain) == (LOOKAHEAD, GAIN)
            t.append(t[-1] + step)
            q.append(numbers(command[1]))
    return np.array(t), np.array(q)


# The last step is a shorter one where the rate does not divide the horizon.
@pytest.mark.parametrize("last", [0.4, 0.396])
def test_urscript_reads_back_to_the_set_points(last, tmp_path):
    given = points(6, np.append(np.arange(50) * 0.008, last))
    write_urscript(given, tmp_path / "motion.script")
    t, q = run_urscript((tmp_path / "motion.script").read_text(encoding="utf-8"))
    assert t == pytest.approx(given.motion.t, abs=1e-7)
    assert q == pytest.approx(given.motion.q, abs=1e-9)


def test_urscript_begins_at_the_first_set_point_or_not_at_all(tmp_path):
    write_urscript(points(6, np.arange(4) * 0.002), tmp_path / "motion.script")
    before, _, _ = (tmp_path / "motion.script").read_text(encoding="utf-8").partition("servoj(")
    assert "get_actual_joint_positions()" in before
    assert f"at[i] - start[i] > {NEAR} or at[i] - start[i] < -{NEAR}:" in before
    assert "halt" in before
    assert "movej" not in before


def test_set_points_for_libfranka_read_back_exactly(tmp_path):
    given = points(7, np.arange(30) * 0.001)
    write_libfranka_csv(given, tmp_path / "motion.csv")
    header, *_ = (tmp_path / "motion.csv").read_text(encoding="utf-8").splitlines()
    assert header == "time,q_d[0],q_d[1],q_d[2],q_d[3],q_d[4],q_d[5],q_d[6]"
    table = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table[:, 0], given.motion.t)
    np.testing.assert_array_equal(table[:, 1:], given.motion.q)


def test_an_arm_gets_the_files_that_it_can_take():
    names = {n: {f.name for f in files_for(arm)} for n, arm in arms().items()}
    plain = {"motion.csv", "joint_trajectory.json", "joint_trajectory.yaml"}
    assert names["two"] == plain
    assert names["six"] == plain | {"motion.script"}
    assert names["seven"] == plain | {"motion_libfranka.csv"}
    first, *rest = arms()["six"].joints
    slides = dataclasses.replace(first, kind="prismatic")
    assert len(files_for(dataclasses.replace(load_arm(UR5), joints=(slides, *rest)))) == len(plain)


def arms():
    panda = load_arm(example_robot("panda_description/urdf/panda.urdf"))
    return {"two": imi_scara(), "six": load_arm(UR5), "seven": panda}


def test_other_numbers_of_joints_are_refused(tmp_path):
    for write, joints in ((write_urscript, 7), (write_libfranka_csv, 6)):
        with pytest.raises(ValueError, match=f"{joints} joints"):
            write(points(joints, np.arange(3) * 0.1), tmp_path / "motion")
    assert not list(tmp_path.iterdir())
