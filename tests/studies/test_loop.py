"""`studies.loop`: a round from the design of a motion to what it told, and motions that repeat."""

import csv
from functools import partial

import numpy as np
import pytest

from oed.diagnosis.diagnose import diagnose
from oed.dynamics.motion import Motion
from studies import loop


def test_a_round_leaves_what_it_bought(tmp_path, monkeypatch):
    """Of one candidate: what is looked at is the loop."""
    monkeypatch.setattr(loop, "diagnose", partial(diagnose, names=("joint_spring",), most=1))
    out = tmp_path / "out"
    given = ["--out", str(out), "--rounds", "1", "--hidden", "joint_spring", "--smoke"]
    assert loop.main(given) == 0
    (row,) = csv.DictReader((out / "rounds.csv").read_text().splitlines())
    assert row["designed for"].startswith("J_d")
    before, after, floor = (
        float(row[f"{name} [N m]"]) for name in ("test before", "test after", "noise floor")
    )
    assert after < before
    assert after == pytest.approx(floor, rel=0.1)  # some hundred rows of noise
    assert (out / "provenance.json").exists()


def test_a_motion_that_is_stretched_to_the_period_of_control_closes():
    """A wave of one period, as a design hands it on: its last sample is a step before the end."""
    t = 3.0 + np.arange(400) * 0.015
    turn = 2 * np.pi / (400 * 0.015)
    phase = (turn * (t - t[0]))[:, None] + np.array([0.3, 1.1])
    short = Motion(t, np.sin(phase), turn * np.cos(phase), -(turn**2) * np.sin(phase))
    motion = loop._whole_period(short)
    assert len(motion.t) * loop.STEP == pytest.approx(loop.PERIOD)
    turn = 2 * np.pi / loop.PERIOD
    phase = (turn * motion.t)[:, None] + np.array([0.3, 1.1])
    # Between samples of 400 a period a chord misses a sine by (2 pi / 400)^2 / 8 at most.
    for found, true in (
        (motion.q, np.sin(phase)),
        (motion.dq / turn, np.cos(phase)),
        (motion.ddq / turn**2, -np.sin(phase)),
    ):
        assert found == pytest.approx(true, abs=1e-4)
