import io

import pytest

from oed.progress import tell, told
from oed.report.progress import progress, shown


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_hands_on_every_item_in_order() -> None:
    assert list(progress(range(5), "cases", stream=io.StringIO())) == [0, 1, 2, 3, 4]


def test_a_quick_job_prints_one_line_in_a_log() -> None:
    log = io.StringIO()
    list(progress(range(1000), "cases", stream=log))
    assert len(log.getvalue().splitlines()) == 1
    assert log.getvalue().startswith("cases: 1000/1000 done in ")


def test_a_slow_job_prints_on_the_way() -> None:
    log = io.StringIO()
    list(progress(iter(range(3)), "cases", total=3, every=0.0, stream=log))
    assert [line.split(",")[0] for line in log.getvalue().splitlines()[:2]] == [
        "cases: 1/3",
        "cases: 2/3",
    ]


def test_an_unknown_total_is_not_made_up() -> None:
    log = io.StringIO()
    list(progress(iter(range(3)), "cases", stream=log))
    assert log.getvalue().startswith("cases: 3 done")


def test_a_terminal_gets_a_bar() -> None:
    terminal = Terminal()
    list(progress(range(3), "cases", stream=terminal))
    assert "100%" in terminal.getvalue()


def heard(stream: io.StringIO, *, quiet: bool = False, every: float = 0.0) -> str:
    """What is displayed of three parts of one work and two of another."""
    with shown(quiet=quiet, every=every, stream=stream):
        for _ in told(range(3), "weights"):
            pass
        tell("search", 7, None)
    return stream.getvalue()


def test_the_library_s_own_work_is_told_by_lines() -> None:
    lines = heard(io.StringIO()).splitlines()
    assert [line.split(",")[0] for line in lines[:3]] == [f"weights: {k}/3" for k in range(3)]
    assert lines[3].startswith("weights: 3/3 done in ")
    assert [line.split(" ")[:2] for line in lines[4:]] == [["search:", "7,"]]


def test_short_work_needs_no_line_and_no_bar() -> None:
    assert heard(io.StringIO(), every=10.0) == ""
    assert "weights" not in heard(Terminal())


def test_quiet_is_quiet_and_nothing_is_heard_afterwards() -> None:
    stream = io.StringIO()
    assert heard(stream, quiet=True) == ""
    with shown(every=0.0, stream=stream):
        pass
    tell("weights", 1, 2)
    assert stream.getvalue() == ""


def test_a_long_work_has_a_bar_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("oed.report.progress.SHORT", 0.0)
    assert "search" in heard(Terminal())
