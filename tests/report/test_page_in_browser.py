import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from oed.report.chart import Chart
from oed.report.page import Page, Picture, Section, Table, Text, Verdict, write_page
from oed.report.style import new_figure
from tests.browser import Browser
from tests.report.chart_examples import charts

LARGEST = 6_000_000  # [B]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "report.html"
    wide = [{f"a rather long column {k}": 1.0 / (k + 1) for k in range(30)}]
    words = Text("an_expression_without_a_blank+" * 20)
    blocks = (words, Table(wide, caption="Wide."), *charts())
    write_page(path, Page("All kinds", Verdict("good", "Fine."), [Section("All", blocks)]))
    return path


class Loaded(HTMLParser):
    """What a page asks for from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]


def test_a_page_holds_all_that_it_needs_once(written: Path) -> None:
    text = written.read_text(encoding="utf-8")
    loaded = Loaded()
    loaded.feed(text)
    assert loaded.addresses == []
    assert len(re.findall('id="plotly"', text)) == 1
    assert len(text.encode()) < LARGEST


def test_a_page_without_charts_is_without_plotly(tmp_path: Path) -> None:
    write_page(tmp_path / "a.html", Page("A", Verdict("good", "B"), [Section("C", [Text("D")])]))
    assert (tmp_path / "a.html").stat().st_size < 20_000


@pytest.mark.parametrize("width", [1280, 400])
def test_opens_offline_without_an_error_and_within_the_window(
    written: Path, browser: Browser, width: int
) -> None:
    seen = browser.look(written, width)
    assert seen.errors == ()
    assert seen.requests == ()
    assert seen.width <= width
    assert seen.drawn == sum(len(chart.traces) for chart in charts(100))


def test_nothing_lies_over_a_figure_that_a_finger_touches(written: Path, browser: Browser) -> None:
    seen = browser.look(written, 400, touched=True)
    assert seen.drawn > 0
    assert seen.toolbars == 0


@pytest.mark.parametrize("width", [1280, 400])
def test_tools_lie_over_no_word_of_a_figure(written: Path, browser: Browser, width: int) -> None:
    assert browser.look(written, width).covered == ()


def test_a_wide_window_has_room_for_tools(written: Path, browser: Browser) -> None:
    assert browser.look(written, 1280).toolbars > 0


@pytest.mark.parametrize(("width", "shown"), [(1280, 1400), (400, 680)])
def test_a_narrow_screen_shows_the_figure_that_was_made_for_it(
    tmp_path: Path, browser: Browser, width: int, shown: int
) -> None:
    picture = Picture(new_figure(7.0, 2.0), "wide", "png", narrow=new_figure(3.4, 2.0))
    page = Page("A", Verdict("good", "B"), [Section("C", [picture])])
    write_page(tmp_path / "a.html", page)
    assert browser.look(tmp_path / "a.html", width).pictures == (shown,)


def test_words_that_lie_over_one_another_are_seen(tmp_path: Path, browser: Browser) -> None:
    """What the tests of real pages rely on."""
    crowded = Chart(
        [{"type": "scatter", "x": [0, 1], "y": [0, 1]}],
        {"annotations": [{"text": text, "x": 0.5, "y": 0.5} for text in ("first", "second")]},
        "C",
        200,
    )
    write_page(tmp_path / "a.html", Page("A", Verdict("good", "B"), [Section("D", [crowded])]))
    (pair,) = browser.look(tmp_path / "a.html", 1280).overlapping
    assert sorted(pair.split(" | ")) == ["first", "second"]
