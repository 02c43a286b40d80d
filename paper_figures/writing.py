"""Where a figure is written, for a script of its own and for all of them."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from oed.commands.options import parse
from oed.report.json_file import write_atomically
from oed.report.style import save_figure

HERE = Path(__file__).resolve().parent
RESULTS = HERE.parent / "results" / "paper"
NAMES = (*(f"figure_{number:02d}" for number in range(2, 12)), "figure_bode")


@dataclass(frozen=True)
class Folders:
    """Draw one figure of the paper.

    Attributes:
        results: What the paper's experiment left.
        out: Where PNG and PDF go.
    """

    results: Path = RESULTS
    out: Path = HERE


def write(draw: Callable[[Path], Figure], name: str) -> None:
    """Command line of one figure: read the results, draw, write PNG and PDF."""
    folders = parse(Folders, prog=f"python -m paper_figures.{name}")
    save_figure(draw(folders.results), folders.out / name)


def write_all(results: Path = RESULTS, out: Path = HERE) -> tuple[Path, ...]:
    """Draw every figure, and the list of their captions; returns what was written."""
    written: list[Path] = []
    captions = []
    for name in NAMES:
        module = importlib.import_module(f"paper_figures.{name}")
        written += save_figure(module.draw(results), out / name)
        captions.append(f"### {name}\n\n![{name}]({name}.png)\n\n{module.CAPTION}\n")
    readme = out / "README.md"
    write_atomically(readme, PREFACE + "\n".join(captions))
    return (*written, readme)


PREFACE = """# Figures of the paper, reproduced

One script a figure; each reads `results/paper/` only, asserts what its caption claims, and writes a
PNG and a PDF beside itself. All of them: `python -m paper_figures`. The data come from
`python -m studies.paper_experiment`; friction is the richer one of `results/paper/summary.md`.

"""
