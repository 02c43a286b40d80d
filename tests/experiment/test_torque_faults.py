"""Held torques and single leaps: what is said of them, and of what only looks like them."""

import numpy as np
import pytest

from oed.experiment.torque_faults import torque_fault_notes

RATE = 200.0  # [Hz]
ROWS = 4000
STILL = slice(1000, 1400)


def _log(seed=0, *, step=0.0):
    """Time, position and torque of a joint that swings, with noise, and with steps if asked for."""
    rng, t = np.random.default_rng(seed), np.arange(ROWS) / RATE
    q = np.sin(1.3 * t) + 0.2 * np.sin(3.1 * t)
    tau = 4 * np.gradient(np.gradient(q, t), t) + 3 * np.sign(np.gradient(q, t))
    tau = tau + 0.05 * rng.normal(size=ROWS)
    return t, q[:, None], (np.round(tau / step) * step if step else tau)[:, None]


def _notes(t, q, tau):
    return list(torque_fault_notes(t, q, tau, "a.csv", np.arange(len(t)) + 2))


@pytest.mark.parametrize("step", [0.0, 0.01, 2.0])
def test_nothing_is_said_of_a_torque_with_noise_steps_and_reversals(step):
    assert _notes(*_log(step=step)) == []


@pytest.mark.parametrize("value", [0.0, 1.234])
def test_a_held_torque_is_named_with_its_rows(value):
    t, q, tau = _log()
    tau[STILL] = value
    (note,) = _notes(t, q, tau)
    assert note.startswith("a.csv, rows 1002 to 1401, column 'tau_1': stays at")
    assert ("drive off" in note) is (value == 0)


def test_a_joint_that_rests_may_hold_its_torque():
    t, q, tau = _log()
    q[STILL], tau[STILL] = q[STILL.start], 1.234
    assert _notes(t, q, tau) == []


def test_a_drive_at_its_limit_may_hold_its_torque():
    t, q, tau = _log()
    assert _notes(t, q, np.clip(tau, -4.0, 4.0)) == []


def test_one_wild_value_is_named_with_its_row():
    t, q, tau = _log()
    tau[1700] += 30.0
    (note,) = _notes(t, q, tau)
    assert note.startswith("a.csv, row 1702, column 'tau_1': ")
    assert "remove it" in note


def test_a_joint_that_rests_for_a_row_between_two_moves_has_no_friction_there():
    """As in a log of ten rows a second of moves from rest to rest."""
    t = np.arange(1000) / 10.0
    move = np.pi * t / 50.0
    q = move - np.sin(2 * move) / 2  # at rest in the middle
    tau = 5.0 * np.sin(t / 3)
    tau[500] = 0.0
    assert _notes(t, q[:, None], tau[:, None]) == []
    moving = _notes(t, t[:, None], tau[:, None])
    assert len(moving) == 1


def test_a_blow_that_lasts_is_no_wild_value():
    t, q, tau = _log()
    tau[1700:1703, 0] += [15.0, 30.0, 10.0]
    assert _notes(t, q, tau) == []


def test_torques_that_are_held_together_share_a_line():
    t, q, tau = _log()
    both = np.hstack([q, q]), np.hstack([tau, 2 * tau])
    both[1][STILL] = 0.0
    (note,) = _notes(t, *both)
    assert note.startswith("a.csv, rows 1002 to 1401, column 'tau_1', 'tau_2': stays at 0")
