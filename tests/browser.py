"""A real browser that opens a page and says what it saw."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Frame

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
PATIENCE = 60_000  # [ms] on a machine with other work

# Pairs of words that lie over one another by more than the bearings of letters [px]. What scrolls within the
# page, as a wide table does, hides what is outside its own edges.
OVERLAPPING = """() => {
  const words = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const node = walk.currentNode, parent = node.parentElement;
    if (!node.textContent.trim() || parent.closest("script, style, noscript, .modebar, .hoverlayer")) continue;
    const style = getComputedStyle(parent);
    if (style.visibility !== "visible" || style.opacity === "0") continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    const scroller = parent.closest(".scroll");
    const edges = scroller ? scroller.getBoundingClientRect() : { left: 0, right: Infinity };
    for (const r of range.getClientRects()) {
      const left = Math.max(r.left, edges.left), right = Math.min(r.right, edges.right);
      if (right > left) words.push({ text: node.textContent.trim(), left, right, top: r.top, bottom: r.bottom, node });
    }
  }
  words.sort((a, b) => a.top - b.top);
  const found = [];
  words.forEach((a, i) => {
    for (let k = i + 1; k < words.length && words[k].top < a.bottom; k++) {
      const b = words[k];
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (a.node !== b.node && wide > 3 && high > 4) found.push(a.text + " | " + b.text);
    }
  });
  return found;
}"""
# Words of a figure that lie under the bar of buttons that comes when a pointer is over it.
COVERED = """() => {
  const found = [];
  for (const bar of document.querySelectorAll(".chart .modebar")) {
    const room = bar.getBoundingClientRect();
    if (!room.width) continue;
    for (const text of bar.closest(".chart").querySelectorAll(".legend text, .annotation text")) {
      const r = text.getBoundingClientRect();
      const wide = Math.min(r.right, room.right) - Math.max(r.left, room.left);
      const high = Math.min(r.bottom, room.bottom) - Math.max(r.top, room.top);
      if (wide > 0 && high > 0) found.push(text.textContent);
    }
  }
  return found;
}"""
# What a recording shows over its whole length: the box around all pixels that are not background, as
# shares of the picture, and the picture's share of its frame.
FILLED = """() => {
  const animator = viewer.animator, canvas = viewer.renderer.domElement;
  animator.pause();
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d", { willReadFrequently: true });
  let [left, right, top, bottom] = [Infinity, -1, Infinity, -1];
  const length = animator.duration || Math.max(...animator.actions.map((a) => a.getClip().duration));
  for (let k = 0; k <= 24; k++) {
    animator.seek(length * k / 24);
    viewer.render();
    pen.drawImage(canvas, 0, 0);
    const { data } = pen.getImageData(0, 0, copy.width, copy.height);
    for (let y = 0; y < copy.height; y++) for (let x = 0; x < copy.width; x++) {
      const at = 4 * (y * copy.width + x);
      if (Math.abs(data[at] - data[0]) + Math.abs(data[at + 1] - data[1]) + Math.abs(data[at + 2] - data[2]) < 12) continue;
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
    }
  }
  const box = canvas.getBoundingClientRect();
  return [(right - left + 1) / copy.width, (bottom - top + 1) / copy.height, box.width / innerWidth, box.height / innerHeight];
}"""


@dataclass(frozen=True)
class Moving:
    """What a moving picture in three dimensions shows over its length.

    Attributes:
        filled: Share of its width and of its height between the outermost pixels that the arm is ever in.
        canvas: Share of its frame's width and height that the picture takes.
        width: Of the frame [px].
    """

    filled: tuple[float, float]
    canvas: tuple[float, float]
    width: int


@dataclass(frozen=True)
class Seen:
    """What a browser saw of a page.

    Attributes:
        errors: Of the console and of scripts.
        requests: Addresses that it asked for, besides the page itself and what stands in it.
        width: Of the page with all that sticks out [px].
        drawn: Lines and sets of points of interactive figures.
        toolbars: Bars of buttons that lie over figures.
        covered: Words of figures under such bars.
        pictures: Width of each picture's own file, of those that it has for several windows [px].
        overlapping: Pairs of words that lie over one another.
        moving: Pictures in three dimensions.
    """

    errors: tuple[str, ...]
    requests: tuple[str, ...]
    width: int
    drawn: int
    toolbars: int
    covered: tuple[str, ...]
    pictures: tuple[int, ...]
    overlapping: tuple[str, ...]
    moving: tuple[Moving, ...]


class Browser:
    """Chromium in a thread of its own: Playwright's event loop would stop others from running."""

    def __init__(self, program: str) -> None:
        self._thread = ThreadPoolExecutor(max_workers=1)
        self._thread.submit(self._open, program).result()

        self._looked: dict[tuple[str, int, int, bool], Seen] = {}

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
        """Open a page in a window of that width [px], and wait until its figures are drawn; once.

        Args:
            path: Of the page.
            width: Of the window [px].
            touched: Whether by a finger, as on a phone, where no pointer hovers.
        """
        key = (str(path), path.stat().st_mtime_ns, width, touched)
        if key not in self._looked:
            self._looked[key] = self._thread.submit(self._look, path, width, touched).result()
        return self._looked[key]

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
            tuple(page.evaluate(COVERED)),
            tuple(page.locator("figure img").evaluate_all("all => all.map(i => i.naturalWidth)")),
            tuple(page.evaluate(OVERLAPPING)),
            tuple(_moving(frame) for frame in page.frames[1:] if _is_replay(frame)),
        )
        page.close()
        return seen


def _is_replay(frame: Frame) -> bool:
    """Whether a frame came with the page, and not with a script of the site."""
    return frame.frame_element().get_attribute("srcdoc") is not None


def _moving(frame: Frame) -> Moving:
    frame.wait_for_function(
        "window.viewer && viewer.animator.actions.length && document.querySelector('canvas')",
        timeout=PATIENCE,
    )
    across, up, wide, high = frame.evaluate(FILLED)
    return Moving((across, up), (wide, high), frame.evaluate("innerWidth"))


def opened() -> Browser:
    """The browser of this machine; skips the test where there is none."""
    pytest.importorskip("playwright", reason="Playwright is not installed")
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is on PATH")
    return Browser(program)
