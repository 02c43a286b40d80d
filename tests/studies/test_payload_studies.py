"""The studies of loads and gains, at smoke size, and what they are made of."""

import numpy as np
import pytest

from oed.dynamics.newton_euler import rigid_body_torque
from oed.estimation.load.quantities import central_inertia
from oed.report.table import read_csv
from oed.robot.inertia import pseudo_inertia
from studies import payload, payload_bound, payload_gains
from studies.carrying_arms import ARMS
from studies.payload_arms import TrueArm, draw_load, random_motion_of
from studies.payload_motion import designed_motion


def test_a_load_is_weighed_and_judged(tmp_path):
    assert payload.main(["--smoke", "--out", str(tmp_path)]) == 0
    (row,) = read_csv(tmp_path / "runs.csv")
    assert row["status"] == "ok"
    assert 0.1 <= row["mass"] <= 5.0
    assert abs(row["mass_error"]) < 3 * row["mass_half"]
    assert row["margin"] > 0
    assert "## How often" in (tmp_path / "summary.md").read_text(encoding="utf-8")


def test_gains_are_found_beside_their_references(tmp_path):
    assert payload_gains.main(["--smoke", "--out", str(tmp_path)]) == 0
    (row,) = read_csv(tmp_path / "runs.csv")
    errors = np.array([float(x) for x in row["error"].split()])
    total = np.array([float(x) for x in row["error_tls"].split()])
    assert np.nanmax(np.abs(errors)) < 0.02
    assert np.abs(total).max() > 3 * np.nanmax(np.abs(errors))


def test_no_random_motion_comes_below_the_bound(tmp_path):
    assert payload_bound.main(["--smoke", "--out", str(tmp_path)]) == 0
    random, bound = read_csv(tmp_path / "runs.csv")
    assert 0 < bound["mass"] < random["mass"]
    assert "How well a load can be told" in (tmp_path / "summary.md").read_text(encoding="utf-8")


def test_loads_can_exist_and_are_as_large_as_they_say():
    rng = np.random.default_rng(0)
    for _ in range(50):
        body = draw_load(rng)
        assert np.linalg.eigvalsh(pseudo_inertia(body))[0] > 0
        assert 0.1 <= body[0] <= 5.0
        largest = np.linalg.eigvalsh(central_inertia(body)).max()
        assert largest <= body[0] / 12 * 2 * 0.25**2


def test_a_true_arm_holds_what_it_is_given():
    rng = np.random.default_rng(1)
    arm = ARMS["scara"]
    true, body = TrueArm.draw(arm, rng), draw_load(rng)
    nothing = 0 * true.coulomb
    still = TrueArm(true.robot, nothing, nothing, nothing, true.speed, nothing)
    motion = random_motion_of(arm, 2.0, rng)
    more = still.holding(arm.frame, body).torque(motion) - still.torque(motion)
    assert still.torque(motion) == pytest.approx(rigid_body_torque(true.robot, motion), abs=1e-8)
    # The quill lifts the whole mass: its weight, and its inertia.
    quill = arm.robot.joint_names.index("quill")
    lifted = np.abs(body[0] * (motion.ddq[:, quill] + 9.81 * np.sign(more[:, quill])))
    assert np.abs(more[:, quill]) == pytest.approx(lifted, rel=0.35)


def test_an_offset_drifts_and_nothing_else_of_it():
    arm = ARMS["scara"]
    true = TrueArm.draw(arm, np.random.default_rng(1))
    days = [true.another_day(np.random.default_rng(2), drift=drift) for drift in (0.0, 0.05)]
    motion = random_motion_of(arm, 2.0, np.random.default_rng(3))
    apart = days[1].torque(motion) - days[0].torque(motion)
    assert np.ptp(apart, axis=0) == pytest.approx(0.0, abs=1e-9)
    assert np.all((apart[0] != 0) & (np.abs(apart[0]) < 0.2 * true.coulomb))


def test_a_designed_motion_stands_still_before_and_after():
    motion = designed_motion("scara", 3.0)
    assert np.all(motion.dq[:100] == 0)
    assert np.all(motion.dq[-100:] == 0)
    assert np.ptp(motion.q, axis=0).max() > 0.1
