"""A report as one HTML file that needs no other: verdict, text, tables and figures."""

from __future__ import annotations

import base64
import gzip
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from oed.report.chart import Chart
from oed.report.json_file import write_atomically
from oed.report.replay import Replay
from oed.report.table import Row, column_names, format_cell, is_numeric

if TYPE_CHECKING:  # a page without such figures is written without loading Matplotlib
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Verdict:
    """What the report comes to, in one box at the top.

    Attributes:
        level: Colour of the box.
        headline: The verdict in one sentence.
        text: Its grounds.
    """

    level: Literal["good", "warning", "bad"]
    headline: str
    text: str = ""
    kind: ClassVar[str] = "verdict"


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text."""

    text: str
    kind: ClassVar[str] = "text"


@dataclass(frozen=True)
class Command:
    """A line to copy into a terminal."""

    text: str
    kind: ClassVar[str] = "command"


@dataclass(frozen=True)
class Table:
    """Rows under a header; a key that a row lacks is an empty cell.

    Attributes:
        rows: One mapping a row.
        caption: What the table shows.
        columns: Keys to show, in this order; all if None.
        digits: Significant digits of numbers with a fraction.
    """

    rows: Sequence[Row]
    caption: str = ""
    columns: Sequence[str] | None = None
    digits: int = 4
    kind: ClassVar[str] = "table"

    @property
    def _shown(self) -> list[tuple[str, bool]]:
        names = column_names(self.rows) if self.columns is None else self.columns
        return [(name, is_numeric(self.rows, name)) for name in names]

    @property
    def header(self) -> list[tuple[str, bool]]:
        """Name of each column and whether it holds numbers."""
        return self._shown

    @property
    def cells(self) -> list[list[tuple[str, bool]]]:
        """Text of each cell, row by row, and whether its column holds numbers."""
        shown = self._shown
        return [
            [(format_cell(row.get(name), digits=self.digits), numeric) for name, numeric in shown]
            for row in self.rows
        ]


@dataclass(frozen=True)
class Picture:
    """A figure with its caption.

    Attributes:
        figure: The figure, or a PNG or SVG file.
        caption: What it shows; also read out in its place.
        file_format: How a figure is embedded: "svg" is sharp at any size, "png" is
            smaller where there are many points.
        narrow: The same for a narrow screen, on which letters of the other would be too small.
    """

    figure: Figure | Path
    caption: str
    file_format: Literal["svg", "png"] = "svg"
    narrow: Figure | None = None
    kind: ClassVar[str] = "picture"

    @property
    def data_uri(self) -> str:
        """The picture as a data URI."""
        if isinstance(self.figure, Path):
            return _file_data_uri(self.figure)
        return figure_data_uri(self.figure, self.file_format)

    @property
    def narrow_data_uri(self) -> str:
        """The picture for a narrow screen, as a data URI; empty where there is none."""
        return "" if self.narrow is None else figure_data_uri(self.narrow, "png")


@dataclass(frozen=True)
class Links:
    """Other pages, each with what it shows.

    Attributes:
        rows: Name, address relative to this page, and what is found there.
    """

    rows: Sequence[tuple[str, str, str]]
    kind: ClassVar[str] = "links"


@dataclass(frozen=True)
class Section:
    """A titled part of the page."""

    title: str
    blocks: Sequence[Text | Verdict | Command | Table | Picture | Chart | Links | Replay]


@dataclass(frozen=True)
class Page:
    """A whole report.

    Attributes:
        title: What the report is about.
        verdict: What it comes to.
        sections: Its parts, in order.
        subtitle: For example the data set and the date.
        footer: For example the versions and the commit.
    """

    title: str
    verdict: Verdict
    sections: Sequence[Section]
    subtitle: str = ""
    footer: str = ""

    @property
    def has_charts(self) -> bool:
        """Whether Plotly is needed."""
        return any(isinstance(b, Chart) for section in self.sections for b in section.blocks)

    @property
    def plotly(self) -> str:
        """Plotly's library, compressed, in base64: a third of its size."""
        return _plotly()


def render_page(page: Page) -> str:
    """The page as HTML; all text is escaped."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_without_folders,
    )
    return environment.get_template("page.html").render(page=page)


# From the root, with folders between; what follows a letter or a digit is a unit or an address.
ABSOLUTE = re.compile(r"(?<![\w./:~])/([^\s/'\"<>]+)/(?:[^\s/'\"<>]+/)*([^\s/'\"<>]+)")


def _without_folders(shown: object) -> object:
    """Text with the names alone of files that it names from the root of this machine.

    A page is handed on, and where its maker keeps his files is no part of it.
    """
    if type(shown) is not str or shown.startswith("data:"):
        return shown  # what is markup already was made here
    return ABSOLUTE.sub(lambda m: m[2] if Path("/", m[1]).is_dir() else m[0], shown)


def write_page(path: str | Path, page: Page) -> None:
    """Write the page, whole or not at all."""
    write_atomically(path, render_page(page))


def figure_data_uri(figure: Figure, file_format: Literal["svg", "png"] = "svg") -> str:
    """A figure as a data URI; the same drawing gives the same text."""
    from oed.report.style import figure_bytes  # noqa: PLC0415  # loads Matplotlib

    return _data_uri(figure_bytes(figure, file_format), file_format)


@cache
def _plotly() -> str:
    library = resources.files("plotly").joinpath("package_data/plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(library, compresslevel=6, mtime=0)).decode("ascii")


def _file_data_uri(file: Path) -> str:
    file_format = file.suffix.lower().removeprefix(".")
    if file_format not in ("png", "svg"):
        raise ValueError(f"{file}: only PNG and SVG files are embedded")
    return _data_uri(file.read_bytes(), file_format)


def _data_uri(content: bytes, file_format: str) -> str:
    kind = {"svg": "image/svg+xml", "png": "image/png"}[file_format]
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"
