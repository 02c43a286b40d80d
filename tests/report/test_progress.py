import io

from oed.report.progress import progress


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
