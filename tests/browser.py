"""A real browser that opens a page and says what it saw."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
PATIENCE = 60_000  # [ms] on a machine with other work


@dataclass(frozen=True)
class Seen:
    """What a browser saw of a page.

    Attributes:
        errors: Of the console and of scripts.
        requests: Addresses that it asked for, besides the page itself and what stands in it.
        width: Of the page with all that sticks out [px].
        drawn: Lines and sets of points of interactive figures.
        toolbars: Bars of buttons that lie over figures.
        pictures: Width of each picture's own file, of those that it has for several windows [px].
    """

    errors: tuple[str, ...]
    requests: tuple[str, ...]
    width: int
    drawn: int
    toolbars: int
    pictures: tuple[int, ...]


class Browser:
    """Chromium in a thread of its own: Playwright's event loop would stop others from running."""

    def __init__(self, program: str) -> None:
        self._thread = ThreadPoolExecutor(max_workers=1)
        self._thread.submit(self._open, program).result()

    def _open(self, program: str) -> None:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415  only where a browser is

        self._playwright = sync_playwright().start()
        self._browser = self._playwright.chromium.launch(executable_path=program, args=FLAGS)

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._thread.submit(self._browser.close).result()
        self._thread.submit(self._playwright.stop).result()
        self._thread.shutdown()

    def look(self, path: Path, width: int, *, touched: bool = False) -> Seen:
        """Open a page in a window of that width [px], and wait until its figures are drawn.

        Args:
            path: Of the page.
            width: Of the window [px].
            touched: Whether by a finger, as on a phone, where no pointer hovers.
        """
        return self._thread.submit(self._look, path, width, touched).result()

    def found(self, path: Path, words: str) -> list[str]:
        """Addresses that the search of a page of the documentation lists for some words."""
        return self._thread.submit(self._found, path, words).result()

    def _found(self, path: Path, words: str) -> list[str]:
        page = self._browser.new_page()
        page.goto(path.resolve().as_uri())
        page.focus("input[name=query]")
        page.keyboard.type(words)
        results = page.locator(".md-search-result__link")
        results.first.wait_for(state="attached", timeout=PATIENCE)
        found = results.evaluate_all("links => links.map(link => link.getAttribute('href'))")
        page.close()
        return found

    def _look(self, path: Path, width: int, touched: bool) -> Seen:
        page = self._browser.new_page(
            viewport={"width": width, "height": 900}, has_touch=touched, is_mobile=touched
        )
        errors: list[str] = []
        requests: list[str] = []
        page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda asked: requests.append(asked.url))
        address = path.resolve().as_uri()
        page.goto(address)
        if page.locator(".chart").count():
            page.wait_for_selector("body[data-charts=drawn]", timeout=PATIENCE)
        seen = Seen(
            tuple(errors),
            tuple(r for r in requests if r != address and not r.startswith(("data:", "blob:"))),
            page.evaluate("document.documentElement.scrollWidth"),
            page.locator(".chart .scatterlayer .trace").count(),
            page.locator(".chart .modebar:visible").count(),
            tuple(page.locator("figure img").evaluate_all("all => all.map(i => i.naturalWidth)")),
        )
        page.close()
        return seen


def opened() -> Browser:
    """The browser of this machine; skips the test where there is none."""
    pytest.importorskip("playwright", reason="Playwright is not installed")
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is on PATH")
    return Browser(program)
