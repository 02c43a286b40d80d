"""How figures look: sized for a journal's columns, readable there, the same every time."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.figure import Figure
from matplotlib.typing import RcKeyType

from oed.report.colours import (
    BLACK,
    BLUE,
    GREEN,
    GREY,  # noqa: F401  # offered with the others
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    YELLOW,
)

COLUMN = 3.4  # [in] width of one column
PAGE = 7.0  # [in] width of both
PAGE_HEIGHT = 9.3  # [in] that a figure and its caption leave on a letter page

STYLE: dict[RcKeyType, Any] = {
    # Yellow comes last: a thin line of it is hard to see on white.
    "axes.prop_cycle": cycler(
        color=[BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK, YELLOW],
    ),
    "font.family": "DejaVu Sans",  # ships with matplotlib: the same on every machine, Greek included
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "axes.titlepad": 3.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.5,
    "lines.linewidth": 0.9,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.dpi": 200,
    "path.simplify": True,
    "agg.path.chunksize": 10000,
    "pdf.fonttype": 42,  # journals refuse Type 3 fonts
    "svg.fonttype": "path",  # an embedded picture cannot rely on the reader's fonts
    "svg.hashsalt": "oed",  # the same drawing gives the same file
}

# Dates, versions and host names out: the same drawing gives the same file.
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": None},
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Creator": None, "Date": None},
}


def deterministic_metadata(file_format: str) -> dict[str, str | None]:
    """Metadata for `Figure.savefig` that leave out what changes from run to run.

    Args:
        file_format: "png", "pdf" or "svg".
    """
    return dict(_METADATA[file_format])


class ShownFigure(Figure):
    """A figure that a notebook shows where it ends a cell, without pyplot."""

    def _repr_png_(self) -> bytes:
        return figure_bytes(self, "png")


def new_figure(width: float, height: float) -> ShownFigure:
    """An empty figure with constrained layout, outside pyplot's global state.

    Args:
        width: Width [in].
        height: Height [in].
    """
    with mpl.rc_context(STYLE):
        return ShownFigure(figsize=(width, height), layout="constrained")


def save_figure(
    figure: Figure, stem: str | Path, formats: Sequence[str] = ("png", "pdf")
) -> tuple[Path, ...]:
    """Write `stem`.png at 200 dpi and `stem`.pdf; the same drawing gives the same bytes.

    Args:
        figure: To write.
        stem: Path without the ending.
        formats: Endings; PNG alone is several times faster and serves a page.

    Returns:
        The files.
    """
    stem = Path(stem)
    stem.parent.mkdir(parents=True, exist_ok=True)
    # Not with_suffix: a stem such as "panda_0.5s" would lose its end.
    files = tuple(stem.with_name(f"{stem.name}.{file_format}") for file_format in formats)
    with mpl.rc_context(STYLE):
        for file, file_format in zip(files, formats, strict=True):
            figure.savefig(file, format=file_format, metadata=deterministic_metadata(file_format))
    return files


def figure_bytes(figure: Figure, file_format: str) -> bytes:
    """What a file of the figure holds; the same drawing gives the same bytes.

    Args:
        figure: To draw.
        file_format: "png", "pdf" or "svg".
    """
    stream = io.BytesIO()
    with mpl.rc_context(STYLE):
        figure.savefig(stream, format=file_format, metadata=deterministic_metadata(file_format))
    return stream.getvalue()
