"""Which rows of a log are a recording, and for what."""

import numpy as np
import pytest

from oed.experiment.importing.propose_roles import Timed, parts_of, propose_roles
from tests.experiment.importing.wave import wave


def shares(parts, logs):
    total = sum(len(log.t) for log in logs)
    found = {}
    for part in parts:
        first, last = part.rows or (0, len(logs[part.log].t))
        found[part.role] = found.get(part.role, 0) + (last - first) / total
    return found


def test_roles_of_one_motion_are_by_time():
    t = np.arange(0, 40, 0.01)
    log = Timed(
        "a", t, np.column_stack([np.sin(0.7 * t) + np.sin(np.sqrt(2) * t), np.sin(0.05 * t**1.5)])
    )
    parts, why = propose_roles([log])
    assert "60, 20 and 20 %" in why
    assert shares(parts, [log]) == pytest.approx(
        {"estimation": 0.6, "validation": 0.2, "test": 0.2}
    )


def test_roles_of_several_motions_are_parted_at_the_pauses():
    rng = np.random.default_rng(1)
    t = np.arange(0, 60, 0.01)
    moving = (t % 10) < 8
    clock = np.cumsum(moving) * 0.01
    rate = rng.uniform(0.5, 1.5, 6)[(t // 10).astype(int)]
    q = np.column_stack([np.sin(np.cumsum(moving * rate) * 0.01), np.cos(1.7 * clock)])
    log = Timed("a", t, q)
    parts, why = propose_roles([log])
    assert "6 motions between pauses" in why
    cuts = [t[part.rows[0]] for part in parts if part.rows and part.rows[0]]
    assert len(cuts) == 2
    assert all(8 < cut % 10 < 10 for cut in cuts)


def test_each_run_of_a_clock_that_is_set_back_is_a_recording():
    rng = np.random.default_rng(1)
    t = np.concatenate([np.arange(0.3 * i, 8 + i, 0.01) for i in range(5)])
    ends = np.flatnonzero(np.diff(t) < 0) + 1
    log = Timed("a", t, rng.standard_normal((len(t), 2)))
    parts, why = propose_roles([log])
    assert "5 runs" in why
    assert [part.role for part in parts] == ["estimation"] * 3 + ["validation", "test"]
    assert [part.rows[0] for part in parts if part.rows] == [0, *ends]
    given = parts_of([log], ["estimation"])
    assert [(part.role, part.rows) for part in given] == [
        ("estimation", part.rows) for part in parts
    ]


def test_a_run_of_too_few_rows_is_left_out_with_a_word():
    t = np.concatenate([np.arange(0, 40, 0.01), np.arange(0, 0.1, 0.01)])
    parts, why = propose_roles([Timed("a", t, wave(t) + t[:, None] ** 1.5)])
    assert [part.rows for part in parts] == [(0, 2400), (2400, 3200), (3200, 4000)]
    assert "1 run of too few rows left out" in why


def test_rows_out_of_order_are_no_runs():
    """Sorting them is the user's: cut there, rows would be lost or count twice."""
    t = np.arange(0, 40, 0.01)
    t[[2000, 2001]] = t[[2001, 2000]]
    assert parts_of([Timed("a", t, wave(t))], ["estimation"])[0].rows is None


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_minutes_at_rest_before_and_after_a_motion_are_left_out(noise):
    """Of shares of the log's time, the first and the last would hold no motion at all."""
    t = np.arange(0, 400, 0.01)
    inside = np.clip(t, 150, 190) - 150
    q = np.column_stack([np.sin(0.7 * inside) + 0.02 * inside, np.cos(np.sqrt(2) * inside)])
    q += noise * np.random.default_rng(1).standard_normal(q.shape)
    parts, why = propose_roles([Timed("a", t, q)])
    assert [part.role for part in parts] == ["estimation", "validation", "test"]
    edges = [t[row] for part in parts if part.rows for row in part.rows]
    assert edges == pytest.approx([149, 174, 174, 182, 182, 191], abs=0.5)
    assert "358 s at the ends" in why


def test_motions_at_a_kilohertz_are_parted_though_the_encoder_is_coarse():
    """17 bits a turn make 0.05 rad/s of each step from row to row."""
    t = np.arange(0, 60, 0.001)
    turn = 2 * np.pi / 2**17
    clock = 8 * (t // 10) + np.minimum(t % 10, 8)
    q = np.column_stack([np.sin(0.8 * clock), np.cos(1.7 * clock + 0.1 * clock**1.2)])
    q += turn * np.random.default_rng(1).uniform(-1, 1, q.shape)
    _, why = propose_roles([Timed("a", t, np.round(q / turn) * turn)])
    assert "6 motions between pauses" in why


def test_roles_of_a_motion_that_repeats_hold_whole_periods():
    t = np.arange(0, 50.0, 0.01)
    angle = 2 * np.pi * t[:, None] / 5.0
    log = Timed("a", t, np.hstack([np.sin(angle), np.cos(2 * angle) + np.sin(angle)]))
    parts, why = propose_roles([log])
    assert "10 times" in why
    assert [part.repetitions for part in parts] == [6, 2, 2]
    assert [part.rows for part in parts] == [(0, 3000), (3000, 4000), (4000, 5000)]


def test_roles_of_several_logs_are_by_name_or_by_order():
    def log(stem):
        t = np.arange(0, 20, 0.01)
        return Timed(stem, t, wave(t))

    by_name, _ = propose_roles([log("run_test"), log("run_train"), log("val-2")])
    assert [part.role for part in by_name] == ["test", "estimation", "validation"]
    by_order, _ = propose_roles([log(f"run{i}") for i in range(5)])
    assert [part.role for part in by_order] == ["estimation"] * 3 + ["validation", "test"]


def test_a_short_log_is_all_for_estimation():
    t = np.arange(0, 0.4, 0.01)
    parts, why = propose_roles([Timed("a", t, wave(t))])
    assert [part.role for part in parts] == ["estimation"]
    assert "too short" in why
