"""Bounds on sums of joint positions, as coupled drives have, held against dense samples."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from oed.design.constraints import LimitConstraints
from oed.design.joint_sums import roomiest_posture
from oed.design.limits import certify, check_limits, fill, repair
from oed.experiment.read_dataset import read_robot
from oed.robot import JointLimits, JointSum, read_sum
from tests.design.problems import HORIZON, classes, lopsided
from tests.experiment.tiny_dataset import MANIFEST, refused, spoil, urdf_text, write_files
from tests.running import oed

DENSE = np.linspace(0.0, HORIZON, 100_000)
COUPLED = JointSum((1.0, 1.0), -1.2, -0.3)
LIMITS = lopsided().with_sums([COUPLED, JointSum((1.0, -0.5), -np.inf, 1.4)])
CLASSES = {name: each for name, each in classes(LIMITS).items() if each.has_offset}


def sums_of(q: np.ndarray) -> np.ndarray:
    """Both sums, smallest and largest, (2, 2)."""
    sums = np.stack([q[:, 0] + q[:, 1], q[:, 0] - q[:, 1] / 2], axis=1)
    return np.stack([sums.min(axis=0), sums.max(axis=0)], axis=1)


@pytest.mark.parametrize("name", CLASSES)
@pytest.mark.parametrize("is_quick", [False, True])
def test_a_repaired_motion_keeps_them_between_samples(name: str, is_quick: bool) -> None:
    trajectory = CLASSES[name]
    for seed in range(3):
        wild = np.random.default_rng(seed).uniform(*(3 * trajectory.bounds.T))
        assert certify(trajectory, wild, LIMITS).violation > 0.0
        z = repair(trajectory, wild, LIMITS, is_quick=is_quick)
        certificate = certify(trajectory, z, LIMITS)
        assert certificate.violation <= 0.0
        seen = sums_of(trajectory.derivative(z, DENSE, 0))
        assert (certificate.sums[:, 0] <= seen[:, 0]).all()
        assert (certificate.sums[:, 1] >= seen[:, 1]).all()
        assert np.abs(certificate.sums - seen).max() < 1e-4
        assert -1.2 <= seen[0, 0] <= seen[0, 1] <= -0.3
        assert seen[1, 1] <= 1.4
        # No smaller than it must be: something is touched, within what a quick look leaves.
        assert certify(trajectory, z, LIMITS).violation > -0.02


def test_one_that_is_broken_is_seen_though_every_joint_keeps_its_own() -> None:
    trajectory = CLASSES["fourier"]
    z = fill(trajectory, trajectory.draw(np.random.default_rng(1)), lopsided())
    assert certify(trajectory, z, lopsided()).violation <= 0.0
    broken = certify(trajectory, z, LIMITS)
    assert broken.violation > 0.0
    assert broken.worst.startswith("sum ")


def test_rows_of_an_optimiser_are_the_sums_and_their_slopes() -> None:
    trajectory, t = CLASSES["fourier"], np.linspace(0.0, HORIZON, 7)
    constraints = LimitConstraints(trajectory, LIMITS, t)
    z = trajectory.draw(np.random.default_rng(0))
    q = trajectory.derivative(z, t, 0)
    rows = np.concatenate([q[:, 0] + q[:, 1], q[:, 0] - q[:, 1] / 2])
    np.testing.assert_allclose(constraints.values(z)[-14:], rows, atol=1e-12)
    assert constraints.count == len(constraints.lower) == len(constraints.upper)
    np.testing.assert_array_equal(constraints.upper[-14:], [-0.3] * 7 + [1.4] * 7)
    step = 1e-6 * np.eye(len(z))
    slopes = [(constraints.values(z + d) - constraints.values(z - d)) / 2e-6 for d in step]
    np.testing.assert_allclose(constraints.jacobian(z).toarray(), np.transpose(slopes), atol=1e-6)


def test_the_roomiest_posture_is_mid_range_or_as_near_as_sums_allow() -> None:
    square = JointLimits.symmetric([1.0, 1.0])
    np.testing.assert_array_equal(roomiest_posture(square), [0.0, 0.0])
    # Of a square's corner that is left by x + y >= 1: as far from the corner's sides, in half
    # ranges, as from the slope (a half range of 1, as it has one side): 1 - x = 2 x - 1.
    corner = square.with_sums([JointSum((1.0, 1.0), 1.0, np.inf)])
    np.testing.assert_allclose(roomiest_posture(corner), [2 / 3, 2 / 3])
    with pytest.raises(ValueError, match="no posture"):
        check_limits(square.with_sums([JointSum((1.0, 1.0), 2.5, 3.0)]))


def test_held_joints_move_the_bounds() -> None:
    factors = {"a": 1.0, "b": 2.0}
    assert JointSum.of(factors, (-1.0, 1.0), ["a"], {"b": 0.25}) == JointSum((1.0,), -1.5, 0.5)
    assert JointSum.of(factors, (-1.0, 1.0), ["c"], {"a": 0.0, "b": 0.5}) is None
    with pytest.raises(ValueError, match="all held"):
        JointSum.of(factors, (-1.0, 1.0), ["c"], {"a": 0.5, "b": 0.5})
    with pytest.raises(ValueError, match="no joint 'b'"):
        JointSum.of(factors, (-1.0, 1.0), ["a"], {})


@pytest.mark.parametrize(
    ("text", "factors"),
    [
        ("joint_2+joint_3:-2.8:2.8", {"joint_2": 1.0, "joint_3": 1.0}),
        ("-joint_2 + 0.5*joint_3:-2.8:2.8", {"joint_2": -1.0, "joint_3": 0.5}),
        ("a-b-joint_2:-2.8:2.8", {"a-b": 1.0, "joint_2": -1.0}),
    ],
)
def test_sums_are_read(text: str, factors: dict[str, float]) -> None:
    assert read_sum(text, ["a-b", "joint_2", "joint_3"]) == (factors, (-2.8, 2.8))


@pytest.mark.parametrize(
    "text", ["", "joint_2", "joint_2:1", "joint_2:a:b", "wrist:0:1", "joint_2joint_2:0:1",
             "joint_2+joint_2:0:1", "0*joint_2:0:1"],
)  # fmt: skip
def test_what_is_no_sum_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"is not|twice|by 0"):
        read_sum(text, ["joint_2"])


HEAD = MANIFEST.partition("[[recording]]")[0].replace("builtin:imi_scara", "robot.urdf")
COMBINATION = '[[limits.combination]]\njoints = ["joint_1", "joint_2"]\nposition = [-0.5, 1.0]\n'


def test_a_design_keeps_what_a_data_set_and_an_option_state(tmp_path: Path) -> None:
    files = {"dataset.toml": (HEAD + COMBINATION).encode(), "robot.urdf": urdf_text(2).encode()}
    data = write_files(tmp_path / "data", files)
    assert read_robot(data).limits.sums == (JointSum((1.0, 1.0), -0.5, 1.0),)
    assert read_robot(data, joints=["joint_2"]).limits.sums == (JointSum((1.0,), -0.5, 1.0),)
    out = tmp_path / "out"
    wish = "joint_1-2*joint_2:-1:3"
    assert oed("design", "--data", data, "--out", out, "--smoke", "--rate", "2000",
               "--no-torque", "--sum", wish) == 0  # fmt: skip
    record = json.loads((out / "design.json").read_text())
    standing = {each["limit"]: each["standing"] for each in record["asked"]}
    assert standing["joint_1 + joint_2 within -0.5 ... 1"] == "proven"
    assert standing["joint_1 - 2 joint_2 within -1 ... 3"] == "proven"
    text = (out / "motion.csv").read_text().splitlines()
    names = text[0].split(",")
    table = np.array([[float(cell) for cell in line.split(",")] for line in text[1:]])
    one, two = (table[:, names.index(f"q_joint_{j}")] for j in (1, 2))
    assert (one + two).min() >= -0.5
    assert (one + two).max() <= 1.0
    assert (one - 2 * two).min() >= -1.0
    assert (one - 2 * two).max() <= 3.0
    assert max(np.ptp(one + two) / 1.5, np.ptp(one - 2 * two) / 4.0) > 0.8


@pytest.mark.parametrize(
    ("more", "key"),
    [
        (COMBINATION.replace("joint_2", "wrist"), "limits.combination[1].joints"),
        (COMBINATION + "factors = [1.0]\n", "limits.combination[1].factors"),
        (COMBINATION + "factors = [0.0, 0]\n", "limits.combination[1].factors"),
        (COMBINATION.replace("-0.5", "1.5"), "limits.combination[1].position"),
        (COMBINATION.replace("position", "velocity"), "limits.combination[1].velocity"),
        ("[limits]\ncombination = 3\n", "limits.combination"),
    ],
)
def test_what_is_no_combination_is_refused(tmp_path: Path, more: str, key: str) -> None:
    old = '[[recording]]\nfile = "est'
    assert refused(spoil(tmp_path, "dataset.toml", old, more + old)).column == key


def test_no_posture_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for wish, told in (("joint_1+joint_2:90:91", "no posture"), ("wrist:0:1", "--sum")):
        out = tmp_path / "out"
        assert oed("design", "--robot", "builtin:imi_scara", "--out", out, "--sum", wish) == 2
        printed = capfd.readouterr()
        assert printed.err.count("\n") == 1
        assert told in printed.err
        assert not out.exists()


def test_limits_of_other_joints_are_refused() -> None:
    with pytest.raises(ValueError, match="a sum of 3 positions"):
        dataclasses.replace(lopsided(), sums=(JointSum((1.0, 0.0, 0.0), 0.0, 1.0),))
