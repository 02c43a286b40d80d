import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oed.design.optimisers.result import HistoryPoint
from oed.design.optimisers.target_hits import (
    compress,
    cost_at,
    expected_cost,
    first_hit,
    hit_curve,
    read_history,
    write_history,
)

HISTORY = (
    HistoryPoint(1, 0.1, np.inf),
    HistoryPoint(5, 0.2, 3.0),
    HistoryPoint(20, 0.9, 1.0),
    HistoryPoint(30, 1.5, 0.5),
)


@pytest.mark.parametrize(("evaluations", "cost"), [(4, np.inf), (5, 3.0), (29, 1.0), (1000, 0.5)])
def test_reads_a_history_at_a_budget(evaluations: int, cost: float) -> None:
    assert cost_at(HISTORY, "evaluations", evaluations) == cost


def test_says_when_a_target_was_hit() -> None:
    assert first_hit(HISTORY, "cpu_s", 1.0) == 0.9
    assert first_hit(HISTORY, "evaluations", 2.0) == 20
    assert first_hit(HISTORY, "evaluations", 0.1) == np.inf


def test_hit_curve_counts_the_seeds() -> None:
    curve = hit_curve(np.array([2.0, 5.0, np.inf, 1.0]), np.array([0.5, 1.0, 3.0, 9.0]))
    np.testing.assert_array_equal(curve, [0.0, 0.25, 0.5, 0.75])


def test_expected_cost_charges_failures_to_successes() -> None:
    assert expected_cost(np.array([2.0, np.inf, 4.0]), np.array([9.0, 10.0, 9.0])) == 8.0
    assert expected_cost(np.array([np.inf]), np.array([3.0])) == np.inf


@given(st.lists(st.floats(-5, 30), min_size=1, max_size=200, unique=True))
@settings(max_examples=50, deadline=None)
def test_compression_loses_neither_end_nor_order(costs: list[float]) -> None:
    ordered = sorted(costs, reverse=True)
    history = [HistoryPoint(i + 1, 0.01 * i, c) for i, c in enumerate(ordered)]
    short = compress(history)
    assert short[0] == history[0]
    assert short[-1] == history[-1]
    assert len(short) <= 32
    assert set(short) <= set(history)
    # A hit is never read early, and late by no more than the next kept level.
    for target in np.linspace(ordered[-1], ordered[0], 5):
        assert first_hit(short, "evaluations", target) >= first_hit(history, "evaluations", target)


def test_a_history_survives_its_text() -> None:
    again = read_history(write_history(HISTORY[1:]))
    assert [p.evaluations for p in again] == [5, 20, 30]
    np.testing.assert_allclose([p.cost for p in again], [3.0, 1.0, 0.5])
    assert read_history("") == ()


def test_compression_keeps_what_a_budget_would_have_found() -> None:
    history = [HistoryPoint(n, 0.1 * n, 1.0 + 1e-3 / n) for n in range(1, 100)]
    history.insert(0, HistoryPoint(0, 0.0, 30.0))
    assert cost_at(compress(history), "cpu_s", 1.05) > cost_at(history, "cpu_s", 1.05)
    short = compress(history, read_at=(1.05, 3.0))
    for seconds in (1.05, 3.0):
        assert cost_at(short, "cpu_s", seconds) == cost_at(history, "cpu_s", seconds)
    assert list(short) == sorted(short, key=lambda point: point.cpu_s)
