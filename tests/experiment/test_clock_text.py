"""Times that are written out, against the dates of pandas."""

import numpy as np
import pandas as pd
import pytest

from oed.experiment.logs.clock_text import clock_seconds, is_clock


@pytest.mark.parametrize(
    "texts",
    [
        ["2026-01-31T10:20:30.5", "2026-01-31T10:20:30.625", "2026-01-31T10:21:00"],
        ["2026-02-28 23:59:59.999999999", "2026-03-01 00:00:00.000000001"],
        ["2024-02-28T23:00:00Z", "2024-03-01T01:30:00Z"],
        ["2026-03-29T01:59:59+01:00", "2026-03-29T03:00:00.25+02:00"],
        ["2026-01-01T00:10:00+0530", "2026-01-01T00:10:01+0530"],
        ["2026-01-01T00:10:00-03", "2026-01-01T00:10:01-03"],
        ["1/31/2026 11:59:59.5 PM", "2/1/2026 12:00:00 AM", "2/1/2026 12:00:00 pm"],
        ["2026/01/31 10:20:30.5", "2026/02/01 10:20:31"],
    ],
)
def test_dates_are_those_of_pandas(texts):
    stamps = pd.Series([pd.Timestamp(text) for text in texts])
    seconds = np.array(clock_seconds(texts), dtype=float)
    expected = [(stamp - stamps[0]).total_seconds() for stamp in stamps]
    assert np.allclose(seconds - seconds[0], expected, rtol=0, atol=2e-9)
    assert 0 <= seconds[0] < 86400


@pytest.mark.parametrize(
    "texts",
    [
        ["31.01.2026 23:59:59.5", "01.02.2026 00:00:00"],
        ["31/01/2026 11:59:59.5 p.m.", "01/02/2026 12:00:00 a.m."],
        ["2/1/2026, 23:59:59.5", "3/1/2026, 0:00:00"],  # two days of January, not of two months
        ["1/2/2026 23:59:59.5", "1/3/2026 0:00:00"],
        ["11:59:59.5 PM", "12:00:00 AM"],
    ],
)
def test_the_order_of_day_and_month_is_what_makes_a_log(texts):
    assert [float(text) for text in clock_seconds(texts)] == [86399.5, 86400.0]


def test_no_nanosecond_is_lost():
    assert clock_seconds(["23:59:59.123456789"]) == ["86399.123456789"]
    assert clock_seconds(["2026-01-31T00:00:00.000000001"]) == ["0.000000001"]


def test_times_of_day_go_on_through_midnight():
    texts = ["23:59:59.5", "0:00:00.5", "20:00:00", "00:00:01"]
    assert [float(text) for text in clock_seconds(texts)] == [86399.5, 86400.5, 158400.0, 172801.0]


@pytest.mark.parametrize(
    "text",
    [
        "10:61:00",
        "25:00:00",
        "10:20",
        "2026-02-30T10:00:00",
        "10:20:30.",
        "13:00:00 PM",
        "31.13.2026 10:00:00",
        "1.5",
        "",
        "noon",
    ],
)
def test_what_is_no_time_is_left_as_it_is(text):
    assert not is_clock(text)
    assert clock_seconds(["10:00:00", text, "10:00:02"])[1] == text
    assert clock_seconds([text, "10:00:00"]) == [text, "10:00:00"]


def test_a_column_is_either_dated_or_not():
    assert clock_seconds(["10:00:00", "2026-01-31T10:00:00"])[1] == "2026-01-31T10:00:00"
    assert clock_seconds(["2026-01-31T10:00:00", "10:00:00"])[1] == "10:00:00"
