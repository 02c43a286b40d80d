"""Three pictures: errors, coverage, bias against spread."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from oed.report.colours import SKY
from oed.report.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PAGE,
    PURPLE,
    STYLE,
    VERMILION,
    new_figure,
)
from studies.estimators.summary import good, held

Line = Mapping[str, str]
LEVEL = 0.95
USUAL = "IDIM-LS"  # what all others are coloured by
MOST = 8.0  # times its error, at which colours end
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, VERMILION, BLACK, GREY, SKY)  # of conditions
MARKERS = "osD^"  # of arms
DARK = 0.5  # mean of red, green and blue below which letters are white


def _grid(lines: Sequence[Line]) -> tuple[list[str], list[str]]:
    """Methods, and arm and condition, in the order in which they came."""
    methods = list(dict.fromkeys(line["method"] for line in lines))
    places = list(dict.fromkeys(f"{line['arm']}, {line['condition']}" for line in lines))
    return methods, places


def _matrix(
    lines: Sequence[Line], value: Callable[[Line], float | None]
) -> tuple[np.ndarray, list[str], list[str]]:
    methods, places = _grid(lines)
    matrix = np.full((len(places), len(methods)), np.nan)
    for line in lines:
        place = places.index(f"{line['arm']}, {line['condition']}")
        found = value(line)
        matrix[place, methods.index(line["method"])] = np.nan if found is None else found
    return matrix, methods, places


def _labelled(
    figure: Figure, shown: np.ndarray, texts: np.ndarray, names: tuple[list[str], list[str]], **look
) -> None:
    axes = figure.add_subplot()
    image = axes.imshow(shown, aspect="auto", **look)
    shades = np.nan_to_num(image.to_rgba(shown)[..., :3].mean(axis=2), nan=1.0)
    for (i, j), text in np.ndenumerate(texts):
        ink = "white" if shades[i, j] < DARK else "black"
        axes.text(j, i, text, ha="center", va="center", fontsize=6, color=ink)
    axes.set_xticks(range(len(names[0])), names[0], rotation=40, ha="right")
    axes.set_yticks(range(len(names[1])), names[1])
    axes.grid(visible=False)


@mpl.rc_context(STYLE)
def plot_error(lines: Sequence[Line]) -> Figure:
    """Torque error on another motion, in per cent, beside that of the usual recipe."""
    matrix, methods, places = _matrix(good(lines), lambda line: 100 * float(line["error"]))
    ratio = matrix / matrix[:, [methods.index(USUAL)]]
    texts = np.where(np.isnan(matrix), "", np.char.mod("%.2g", np.nan_to_num(matrix)))
    figure = new_figure(PAGE, 1.6 + 0.2 * len(places))
    look = {"cmap": "RdBu_r", "norm": LogNorm(1 / MOST, MOST)}
    _labelled(figure, np.clip(ratio, 1 / MOST, MOST), texts, (methods, places), **look)
    figure.axes[0].set_title(
        f"torque error on another motion [%]; blue: less than {USUAL}, red: more"
    )
    return figure


@mpl.rc_context(STYLE)
def plot_coverage(lines: Sequence[Line]) -> Figure:
    """Share of 95 % intervals that hold the truth."""
    told = [line for line in good(lines) if held(line) is not None]
    matrix, methods, places = _matrix(told, held)
    texts = np.where(np.isnan(matrix), "", np.char.mod("%.2f", np.nan_to_num(matrix)))
    figure = new_figure(PAGE, 1.6 + 0.2 * len(places))
    _labelled(figure, matrix - LEVEL, texts, (methods, places), cmap="RdBu", vmin=-0.6, vmax=0.6)
    figure.axes[0].set_title("share of 95 % intervals that hold the truth (red: too few)")
    return figure


@mpl.rc_context(STYLE)
def plot_bias(lines: Sequence[Line]) -> Figure:
    """What more data would not mend against what it would, a point a method and condition."""
    figure = new_figure(PAGE, 3.6)
    axes = figure.add_subplot()
    done = good(lines)
    colours = dict(zip(dict.fromkeys(x["condition"] for x in done), COLOURS, strict=False))
    markers = dict(zip(dict.fromkeys(x["arm"] for x in done), MARKERS, strict=False))
    for line in done:
        axes.loglog(
            100 * float(line["spread"]),
            100 * float(line["bias"]),
            markers[line["arm"]],
            color=colours[line["condition"]],
            markersize=3.5,
            alpha=0.8,
        )
    for name, colour in colours.items():
        axes.plot([], [], "o", color=colour, markersize=3.5, label=name)
    for name, marker in markers.items():
        axes.plot([], [], marker, color="none", markeredgecolor=BLACK, markersize=3.5, label=name)
    ends = np.array(axes.get_xlim())
    axes.plot(ends, ends, "-", color="0.6", linewidth=0.8)
    axes.set(xlabel="spread [% of torque]", ylabel="bias [% of torque]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


PICTURES: dict[str, Callable[[Sequence[Line]], Figure]] = {
    "error": plot_error,
    "coverage": plot_coverage,
    "bias": plot_bias,
}
