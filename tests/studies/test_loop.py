"""`studies.loop`: a round from the design of a motion to what it told, and motions that repeat."""

import csv

import numpy as np
import pytest

from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.motion import Motion
from studies import loop

NAMES = ("stribeck", "nonlinear_viscous", "torque_offset", "torque_ripple", "motor_coupling")


def test_the_loop_finds_friction_that_its_first_motion_does_not_show(tmp_path, monkeypatch):
    """What falls below 0.1 rad/s is crossed in no time by the motion that tells inertias best."""
    out = tmp_path / "out"
    settings = DiagnosisSettings(surrogates=99, bootstrap=40, candidates=NAMES)
    monkeypatch.setattr(loop.Config, "settings", settings)
    assert loop.main(["--out", str(out), "--rounds", "2"]) == 0
    first, second = csv.DictReader((out / "rounds.csv").read_text().splitlines())
    assert first["effects"] == ""
    assert second["designed for"].startswith("in doubt: ")
    assert second["effects"] == "stribeck_1"
    before, after, floor = (
        float(second[f"{name} [N m]"]) for name in ("test before", "test after", "noise floor")
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
